//! Fits the texture coordinates of a refitted level by least squares to the input's, over the faces
//! around each: what lies between vertices counts, where looking values up at the vertices alone
//! lets a texture slide inside of large triangles.

use crate::attributes::stays;
use crate::blend::store;
use crate::interpolation::{Interpolation, Target};
use crate::level::CoarseMesh;
use crate::ties::SurfaceTie;
use glam::DVec3;
use lodc_mesh::{Attribute, Mesh, MeshParts, NONE, Semantic};
use lodc_nearest::point_at;

/// How far from a face's own coordinates those at a tie may be, in its extent in the texture: what
/// is farther lies beyond a seam. Chosen by hand.
const MAX_JUMP: f64 = 1.0;

/// Returns whether a mesh has anything to be fitted.
pub(crate) fn is_there(mesh: &Mesh) -> bool {
    mesh.attributes().iter().any(is_fitted)
}

fn is_fitted(stream: &Attribute) -> bool {
    matches!(stream.semantic, Semantic::TexCoord(_)) && stream.morph_target.is_none()
}

/// Replaces the texture coordinates in `parts`, a level of `mesh`, by those that fit the mesh's
/// best at `ties`. Starts from those that are there. Vertices that shared position and coordinates
/// still do, so no seam opens.
pub(crate) fn fit(mesh: &Mesh, level: &CoarseMesh, ties: &[SurfaceTie], parts: &mut MeshParts) {
    let befores = level.mesh.attributes().iter();
    let streams = mesh.attributes().iter().zip(befores).filter(|(from, _)| stays(from));
    for ((from, before), now) in streams.zip(&mut parts.attributes) {
        if !is_fitted(from) {
            continue;
        }
        let (of_vertex, first) = unknowns(level, before, now);
        let faces: Vec<[u32; 3]> =
            level.mesh.triangles().iter().map(|t| t.map(|v| of_vertex[v as usize])).collect();
        let mut system = Interpolation::new(&faces, first.len());
        for tie in ties {
            let corners = faces[tie.face as usize].map(|u| first[u as usize]);
            let vertices = mesh.triangles()[tie.triangle as usize];
            let target = Target {
                face: tie.face,
                barycentric: tie.on_face,
                value: point_at(vertices.map(|v| coordinates(from, v)), tie.on_triangle),
                weight: tie.weight,
            };
            let extent = (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3]));
            let jump = system.interpolated(&target, &first).distance(target.value);
            if jump <= MAX_JUMP * extent.fold(0.0, f64::max) {
                system.add(&target);
            }
        }
        let solved = system.solve(&first, &first);
        for (v, &unknown) in of_vertex.iter().enumerate() {
            let value = solved[unknown as usize];
            if value.is_finite() {
                store(now, v, &[value.x, value.y]);
            }
        }
    }
}

/// For each vertex of a level its unknown, one for all that share submesh, position and what the
/// simplifier left them of a stream; and the mean of what `now` has for each.
fn unknowns(level: &CoarseMesh, before: &Attribute, now: &Attribute) -> (Vec<u32>, Vec<DVec3>) {
    let key = |v: u32| {
        let submesh = level.mesh.vertex_submesh()[v as usize];
        (level.point_of_vertex[v as usize], submesh, before.at(v))
    };
    let mut order: Vec<u32> = (0..level.mesh.vertex_count() as u32).collect();
    order.sort_unstable_by(|&a, &b| key(a).cmp(&key(b)).then(a.cmp(&b)));
    let (mut of_vertex, mut first) = (vec![NONE; order.len()], Vec::new());
    for equal in order.chunk_by(|&a, &b| key(a) == key(b)) {
        equal.iter().for_each(|&v| of_vertex[v as usize] = first.len() as u32);
        let sum: DVec3 = equal.iter().map(|&v| coordinates(now, v)).sum();
        first.push(sum / equal.len() as f64);
    }
    (of_vertex, first)
}

fn coordinates(stream: &Attribute, v: u32) -> DVec3 {
    DVec3::new(stream.value(v, 0).into(), stream.value(v, 1).into(), 0.0)
}
