//! A scene as one plain mesh in one space, for programs that look at it.

use super::ExportObject;
use super::flatten::{self, component, stream};
use crate::{FormatError, Scene};
use lodc_mesh::Semantic;

/// All triangles of a scene as its nodes show them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlatMesh {
    /// Positions in the scene.
    pub positions: Vec<[f32; 3]>,
    /// Corners, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One normal per position; empty unless every submesh has them.
    pub normals: Vec<[f32; 3]>,
    /// One pair of texture coordinates per position; empty unless every submesh has them.
    pub texture: Vec<[f32; 2]>,
}

/// Flattens a scene. A mesh that several nodes show is repeated.
///
/// # Errors
/// If its instances together are too large.
pub fn flat_mesh(scene: &Scene) -> Result<FlatMesh, FormatError> {
    let objects: Vec<_> = scene.objects.iter().map(|o| ExportObject { info: &o.info, mesh: &o.mesh }).collect();
    let placed = flatten::placed(&scene.document, &objects)?;
    let all_have = |semantic: &Semantic| {
        placed
            .iter()
            .all(|p| (0..p.object.mesh.submeshes().len()).all(|s| stream(p.object.mesh, s, semantic).is_some()))
    };
    let (normals, texture) = (all_have(&Semantic::Normal), all_have(&Semantic::TexCoord(0)));
    let mut flat = FlatMesh::default();
    for p in &placed {
        let (mesh, first, mirrors) = (p.object.mesh, flat.positions.len() as u32, p.mirrors());
        for (v, &submesh) in (0..).zip(mesh.vertex_submesh()) {
            flat.positions.push(p.position(v));
            let of = |semantic| stream(mesh, submesh as usize, &semantic);
            if normals && let Some(s) = of(Semantic::Normal) {
                flat.normals.push(p.normal(s, v));
            }
            if texture && let Some(s) = of(Semantic::TexCoord(0)) {
                flat.texture.push([component(s, v, 0), component(s, v, 1)]);
            }
        }
        flat.triangles.extend(mesh.triangles().iter().map(|&t| p.corners(t, mirrors).map(|v| first + v)));
    }
    Ok(flat)
}
