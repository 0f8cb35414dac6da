//! Sides of faces, sorted by edge.

use rayon::prelude::*;

/// One side of a face on an undirected edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Side {
    /// The ends of the edge, the smaller first.
    pub(crate) edge: [u32; 2],
    /// `3 * face + corner`: from that corner of the face to the next.
    pub(crate) half_edge: u32,
}

impl Side {
    pub(crate) fn face(self) -> usize {
        self.half_edge as usize / 3
    }

    pub(crate) fn corner(self) -> usize {
        self.half_edge as usize % 3
    }
}

/// Returns all sides of faces, those of one edge one after another.
pub(crate) fn sides(faces: &[[u32; 3]]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(3 * faces.len());
    for (half_edge, face) in (0..).step_by(3).zip(faces) {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            sides.push(Side { edge: [a.min(b), a.max(b)], half_edge: half_edge + k as u32 });
        }
    }
    sides.par_sort_unstable();
    sides
}
