//! Drops degenerate triangles and unused vertices, which take no part in any level of detail, and
//! counts them.

use crate::{MeshParts, NONE, is_degenerate, position_key};

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
    /// then vertices that no triangle uses. Returns how many there were.
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
        let mut remaining = Vec::with_capacity(self.triangles.len());
        for submesh in &mut self.submeshes {
            let first = remaining.len();
            remaining.extend(self.triangles[submesh.triangles()].iter().copied().filter(|t| {
                let keys = t.map(|v| position_key(self.positions[v as usize]));
                !is_degenerate(keys)
            }));
            submesh.first_triangle = first as u32;
            submesh.triangle_count = (remaining.len() - first) as u32;
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
