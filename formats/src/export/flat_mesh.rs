//! A scene as one plain mesh in one space, for programs that look at it.

use super::ExportObject;
use super::flatten::{self, Placed, component, stream};
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
    /// One pair of texture coordinates per position, zeros where a submesh has none; empty if none
    /// has any.
    pub texture: Vec<[f32; 2]>,
    /// True if every submesh has texture coordinates.
    pub all_textured: bool,
    /// For each triangle, its object in the scene and its submesh there.
    pub submesh_of: Vec<[u32; 2]>,
}

/// Flattens a scene. A mesh that several nodes show is repeated. `set` says which texture
/// coordinates an object's submesh is read with.
///
/// # Errors
/// If its instances together are too large.
pub fn flat_mesh(
    scene: &Scene,
    set: &dyn Fn(usize, usize) -> u32,
) -> Result<FlatMesh, FormatError> {
    let objects: Vec<_> =
        scene.objects.iter().map(|o| ExportObject { info: &o.info, mesh: &o.mesh }).collect();
    let placed = flatten::placed(&scene.document, &objects)?;
    // What is placed borrows from the scene, so an object is known by where it is.
    let number = |p: &Placed<'_>| {
        objects.iter().position(|o| std::ptr::eq(o.info, p.object.info)).unwrap_or(0)
    };
    let numbers: Vec<usize> = placed.iter().map(number).collect();
    let has = |semantic: &dyn Fn(usize, usize) -> Semantic| -> Vec<bool> {
        let submeshes = |(p, &o): (&Placed<'_>, &usize)| {
            let mesh = p.object.mesh;
            let found = |s: usize| stream(mesh, s, &semantic(o, s)).is_some();
            (0..mesh.submeshes().len()).map(found).collect::<Vec<bool>>()
        };
        placed.iter().zip(&numbers).flat_map(submeshes).collect()
    };
    let texture_set = |o: usize, s: usize| Semantic::TexCoord(set(o, s));
    let normals = has(&|_, _| Semantic::Normal).into_iter().all(|found| found);
    let textured = has(&texture_set);
    let texture = textured.contains(&true);
    let mut flat =
        FlatMesh { all_textured: texture && !textured.contains(&false), ..FlatMesh::default() };
    for (p, &o) in placed.iter().zip(&numbers) {
        let (mesh, first, mirrors) = (p.object.mesh, flat.positions.len() as u32, p.mirrors());
        for (v, &submesh) in (0..).zip(mesh.vertex_submesh()) {
            flat.positions.push(p.position(v));
            let of = |semantic| stream(mesh, submesh as usize, &semantic);
            if normals && let Some(s) = of(Semantic::Normal) {
                flat.normals.push(p.normal(s, v));
            }
            if texture {
                let stream = of(texture_set(o, submesh as usize));
                flat.texture
                    .push(stream.map_or([0.0; 2], |s| [component(s, v, 0), component(s, v, 1)]));
            }
        }
        for (s, submesh) in (0..).zip(mesh.submeshes()) {
            flat.submesh_of.extend(submesh.triangles().map(|_| [o as u32, s]));
        }
        flat.triangles
            .extend(mesh.triangles().iter().map(|&t| p.corners(t, mirrors).map(|v| first + v)));
    }
    Ok(flat)
}
