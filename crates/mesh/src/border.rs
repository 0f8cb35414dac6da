//! Borders: edges with one face.

use crate::{Mesh, is_degenerate};

impl Mesh {
    /// Returns a vertex at either end of each border edge. Edges are pairs of positions, and faces
    /// at the same three positions count as one: both sides of a sheet have the same border.
    #[must_use]
    pub fn border_edges(&self) -> Vec<[u32; 2]> {
        let ids = self.position_ids();
        // Each edge as the positions of its ends, the smaller first, and a vertex at either.
        let mut edges: Vec<([u32; 2], [u32; 2])> = Vec::new();
        for triangle in ids.distinct(self.triangles()) {
            let corners = self.triangles()[triangle as usize];
            let positions = corners.map(|v| ids.of_vertex[v as usize]);
            if is_degenerate(positions) {
                continue;
            }
            for k in 0..3 {
                let next = (k + 1) % 3;
                let (a, b) = (positions[k], positions[next]);
                let vertices = [corners[k], corners[next]];
                edges.push(([a.min(b), a.max(b)], vertices));
            }
        }
        edges.sort_unstable();
        let alone = edges.chunk_by(|a, b| a.0 == b.0).filter(|faces| faces.len() == 1);
        alone.map(|edge| edge[0].1).collect()
    }
}
