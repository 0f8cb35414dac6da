//! Strips of a part of the surface, as the local search changes them.

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
    pub(crate) fn indices(&self, path: &[u32]) -> Vec<u32> {
        let mut indices = Vec::with_capacity(path.len() + 4);
        write_path(
            path,
            &self.triangles,
            |t, slot| self.neighbours[t as usize][slot as usize],
            &mut indices,
        );
        indices
    }
    /// The same triangles from the other end.
    pub(crate) fn reversed(&self, path: &[u32]) -> Vec<u32> {
        let mut reversed = Vec::with_capacity(path.len());
        for i in (0..path.len()).rev() {
            let (t, _) = decode(path[i]);
            let leave = if i == 0 {
                3
            } else {
                let (before, left) = decode(path[i - 1]);
                decode(self.neighbours[before as usize][left as usize]).1
            };
            reversed.push(code(t, leave));
        }
        reversed
    }
}
