//! Neighbour pointers of triangles, as opposite half-edges.
//!
//! Half-edge `3t + c` leads from corner `c` of triangle `t` to the next one; corner and half-edge
//! share the number.

use lodc_mesh::{Mesh, NONE, PositionIds};
use rayon::prelude::*;

/// The next half-edge of the same triangle.
pub(super) fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
}

/// The previous half-edge of the same triangle.
pub(super) fn previous(half_edge: u32) -> u32 {
    if half_edge.is_multiple_of(3) { half_edge + 2 } else { half_edge - 1 }
}

/// For each half-edge the one across it, [`NONE`] at borders. Edges are compared by position, so
/// surfaces hang together across seams and submeshes; where more than two triangles share an edge,
/// they are paired by number.
pub(super) fn opposites(mesh: &Mesh, positions: &PositionIds) -> Vec<u32> {
    let corners = mesh.triangles().as_flattened();
    let ends = |h: u32| [h, next(h)].map(|c| positions.of_vertex[corners[c as usize] as usize]);
    let mut edges: Vec<([u32; 2], u32)> = (0..corners.len() as u32)
        .map(|h| {
            let [a, b] = ends(h);
            ([a.min(b), a.max(b)], h)
        })
        .collect();
    edges.par_sort_unstable();
    let mut opposite = vec![NONE; corners.len()];
    for edge in edges.chunk_by(|a, b| a.0 == b.0) {
        let runs_up = |&&(_, h): &&([u32; 2], u32)| ends(h)[0] == edge[0].0[0];
        let down = edge.iter().filter(|h| !runs_up(h));
        for (&(_, up), &(_, down)) in edge.iter().filter(runs_up).zip(down) {
            opposite[up as usize] = down;
            opposite[down as usize] = up;
        }
    }
    opposite
}
