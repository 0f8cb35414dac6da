//! A LOD's index list made from the sequence alone: what a far jump is measured against.

use lodc_mesh::{Lod, Simplified};

/// Makes index lists from scratch. It is the reference answer ([`Simplified::triangles_at`]) with
/// everything prepared that does not depend on the LOD and nothing allocated, so a jump that is
/// faster does better than starting again.
#[derive(Clone, Debug)]
pub struct Rebuild<'a> {
    simplified: &'a Simplified,
    /// The position of each vertex.
    positions: Vec<u32>,
    /// What each vertex has become at the LOD.
    resolved: Vec<u32>,
    indices: Vec<u32>,
}

impl<'a> Rebuild<'a> {
    /// Prepares everything.
    #[must_use]
    pub fn new(simplified: &'a Simplified) -> Self {
        let mesh = simplified.mesh();
        Self {
            simplified,
            positions: mesh.position_ids().of_vertex,
            resolved: vec![0; mesh.vertex_count()],
            indices: Vec::with_capacity(3 * mesh.triangles().len()),
        }
    }

    /// The live triangles at the LOD shown for `lod`, three vertices each, in the order of the
    /// mesh.
    pub fn indices_at(&mut self, lod: Lod) -> &[u32] {
        let collapses = self.simplified.collapses();
        let end = collapses.floor(lod).0 as usize;
        for (v, resolved) in self.resolved.iter_mut().enumerate().skip(end) {
            *resolved = v as u32;
        }
        for (v, &target) in collapses.targets()[..end].iter().enumerate().rev() {
            self.resolved[v] = self.resolved[target as usize];
        }
        self.indices.clear();
        for triangle in self.simplified.mesh().triangles() {
            let corners = triangle.map(|v| self.resolved[v as usize]);
            let [a, b, c] = corners.map(|v| self.positions[v as usize]);
            if a != b && b != c && c != a {
                self.indices.extend_from_slice(&corners);
            }
        }
        &self.indices
    }
}
