//! The vocabulary crate, seen from outside: every promise of its documentation.

mod attribute;
mod chain;
mod clean;
mod groups;
mod mesh;
mod motion;
mod multiset;
mod position;
mod sequence;
mod simplified;
mod weld;

use lodc_mesh::{MeshParts, Submesh};

/// One submesh without streams.
fn parts(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> MeshParts {
    MeshParts {
        positions: positions.to_vec(),
        vertex_submesh: vec![0; positions.len()],
        attributes: Vec::new(),
        triangles: triangles.to_vec(),
        submeshes: vec![Submesh { triangle_count: triangles.len() as u32, ..Submesh::default() }],
    }
}

const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
