//! A strip as a path over triangles and as indices, and the small surface that it lies on: what the
//! local search (`window`) changes.

use crate::adjacency::{Neighbours, code, decode};
use crate::cover::write_path;

/// A strip: its triangles with the slot through which each is left (3 at the end), and its
/// vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct Strip {
    pub(crate) path: Vec<u32>,
    pub(crate) indices: Vec<u32>,
}

/// Triangles and their neighbours, numbered by themselves.
pub(crate) struct Surface {
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) neighbours: Neighbours,
}

impl Surface {
    /// Appends the indices of a path.
    pub(crate) fn write_indices(&self, path: &[u32], indices: &mut Vec<u32>) {
        let neighbour = |t: u32, slot: u32| self.neighbours[t as usize][slot as usize];
        write_path(path, &self.triangles, neighbour, indices);
    }
    /// Appends to `reversed` the path with the same triangles from the other end.
    pub(crate) fn write_reversed(&self, path: &[u32], reversed: &mut Vec<u32>) {
        // The slot through which a triangle is left is that through which it was entered.
        let mut entered = 3;
        let first = reversed.len();
        for &c in path {
            let (t, slot) = decode(c);
            reversed.push(code(t, entered));
            if slot != 3 {
                entered = decode(self.neighbours[t as usize][slot as usize]).1;
            }
        }
        reversed[first..].reverse();
    }
}
