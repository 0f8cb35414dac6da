//! Drops degenerate triangles and unused vertices, which take no part in any level of detail, and
//! counts them.

use crate::{MeshParts, NONE, position_key};

/// Counts of what [`MeshParts::clean`] dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cleaning {
    /// Triangles with two corners at one position.
    pub degenerate_triangles: usize,
    /// Vertices that no remaining triangle uses.
    pub unreferenced_vertices: usize,
}

impl MeshParts {
    /// Drops what takes no part in a level of detail: triangles with two corners at one position,
    /// at rest and in motion, then vertices that no triangle uses. Returns how many there were.
    ///
    /// # Panics
    /// If a triangle names a vertex that does not exist, a submesh a triangle that does not exist,
    /// or a stream has too few bytes: importers check that first.
    pub fn clean(&mut self) -> Cleaning {
        let degenerate_triangles = self.drop_degenerate();
        let vertices = self.positions.len();
        self.drop_unreferenced();
        let unreferenced_vertices = vertices - self.positions.len();
        Cleaning { degenerate_triangles, unreferenced_vertices }
    }

    /// Drops triangles with two corners at one position, and keeps all vertices. Returns how many
    /// there were.
    ///
    /// # Panics
    /// As [`Self::clean`].
    pub fn drop_degenerate(&mut self) -> usize {
        let count_before = self.triangles.len();
        let motion = self.motion();
        let is_live = |t: &&[u32; 3]| {
            let keys = t.map(|v| position_key(self.positions[v as usize]));
            let meet = |[i, j]: [usize; 2]| keys[i] == keys[j] && motion.move_alike(t[i], t[j]);
            ![[0, 1], [1, 2], [2, 0]].into_iter().any(meet)
        };
        let mut remaining = Vec::with_capacity(self.triangles.len());
        let mut ends = Vec::with_capacity(self.submeshes.len());
        for submesh in &self.submeshes {
            remaining.extend(self.triangles[submesh.triangles()].iter().filter(is_live));
            ends.push(remaining.len() as u32);
        }
        let mut first = 0;
        for (submesh, end) in self.submeshes.iter_mut().zip(ends) {
            submesh.first_triangle = std::mem::replace(&mut first, end);
            submesh.triangle_count = end - submesh.first_triangle;
        }
        self.triangles = remaining;
        count_before - self.triangles.len()
    }

    fn drop_unreferenced(&mut self) {
        let mut used = vec![false; self.positions.len()];
        for &v in self.triangles.as_flattened() {
            used[v as usize] = true;
        }
        let sources: Vec<u32> = (0..used.len() as u32).filter(|&v| used[v as usize]).collect();
        if sources.len() == used.len() {
            return;
        }
        let mut new_index = vec![NONE; used.len()];
        for (new, &old) in (0..).zip(&sources) {
            new_index[old as usize] = new;
        }
        self.positions = sources.iter().map(|&v| self.positions[v as usize]).collect();
        self.vertex_submesh = sources.iter().map(|&v| self.vertex_submesh[v as usize]).collect();
        for a in &mut self.attributes {
            *a = a.gathered(sources.iter().copied());
        }
        for t in &mut self.triangles {
            *t = t.map(|v| new_index[v as usize]);
        }
    }
}
