//! Masking Strips: filters against every subsequence, and everything against the reference.

mod filters;
mod masks;
mod replay;

use super::*;
use lodc_fixtures as fixtures;
use lodc_mesh::{CollapseSequence, Mesh, MeshParts, SequenceParts, Submesh};
use lodc_strip::StripSet;

/// A flat mesh of one submesh with its vertices already in collapse order, one record a step, and
/// strips that draw it.
fn model(vertices: u32, targets: &[u32], strips: &[&[u32]]) -> Masking {
    let set = strip_set(strips);
    let triangles: Vec<_> = set.triangles().map(|t| t.corners).collect();
    let mesh = Mesh::try_from(MeshParts {
        positions: (0..vertices).map(|v| [v as f32, (v * v) as f32, 0.0]).collect(),
        vertex_submesh: vec![0; vertices as usize],
        attributes: Vec::new(),
        submeshes: vec![Submesh {
            first_triangle: 0,
            triangle_count: triangles.len() as u32,
            attributes: Vec::new(),
        }],
        triangles,
    })
    .expect("a mesh");
    let live = |lod: u32| {
        let resolve = |mut v: u32| {
            while v < lod {
                v = targets[v as usize];
            }
            v
        };
        let corners = mesh.triangles().iter().map(|t| t.map(resolve));
        corners.filter(|[a, b, c]| a != b && b != c && c != a).count() as u32
    };
    let collapses = CollapseSequence::try_from(SequenceParts {
        targets: targets.to_vec(),
        step_ends: (1..vertices).collect(),
        step_errors: vec![0.0; targets.len()],
        step_triangles: (1..vertices).map(live).collect(),
        triangles: live(0),
        ..SequenceParts::default()
    })
    .expect("a sequence");
    let simplified = Arc::new(Simplified::new(mesh, collapses).expect("the two fit"));
    Masking::build(&simplified, Arc::new(set)).expect("few entries")
}

fn strip_set(strips: &[&[u32]]) -> Strips {
    let ends = strips.iter().scan(0, |end, strip| {
        *end += strip.len() as u32;
        Some(*end)
    });
    let set = StripSet::from_parts(strips.concat(), ends.collect(), vec![strips.len() as u32])
        .expect("ends rise");
    Strips { kind: lodc_strip::StripKind::Cache, set }
}

/// A mask as the thesis prints it: the first position first.
fn bits(mask: u16, len: usize) -> String {
    (0..len).map(|at| if mask >> at & 1 == 1 { '1' } else { '0' }).collect()
}
