//! Wedge groups: the vertices at one position whose triangles are connected through edges at that
//! position. A half-edge collapse moves a group.

use crate::{DisjointSets, Mesh, NONE, PositionIds};

/// The wedge groups of a mesh, numbered in order of their first vertex.
#[derive(Clone, Debug)]
pub struct WedgeGroups {
    /// The group of each vertex.
    pub of_vertex: Vec<u32>,
    /// The first vertex of each group.
    pub first_vertex: Vec<u32>,
}

impl WedgeGroups {
    /// Finds the groups: at each position, vertices are joined if their triangles share an edge at
    /// that position, edges being compared by position. Two surfaces that touch only in a point
    /// stay two groups.
    #[must_use]
    pub fn new(mesh: &Mesh, positions: &PositionIds) -> Self {
        let mut sets = DisjointSets::new(mesh.vertex_count());
        // Where a position has one vertex, as nearly everywhere, there is nothing to join: corners
        // there are skipped.
        let mut vertices_at = vec![0u32; positions.len()];
        for &p in &positions.of_vertex {
            vertices_at[p as usize] += 1;
        }
        // One entry for each corner and each of its two edges: the corner's position, the position
        // of the edge's other end, the corner's vertex.
        let mut spokes = Vec::new();
        for t in mesh.triangles() {
            for c in 0..3 {
                let (v, next, previous) = (t[c], t[(c + 1) % 3], t[(c + 2) % 3]);
                let p = positions.of_vertex[v as usize];
                if vertices_at[p as usize] > 1 {
                    spokes.push((p, positions.of_vertex[next as usize], v));
                    spokes.push((p, positions.of_vertex[previous as usize], v));
                }
            }
        }
        spokes.sort_unstable();
        for pair in spokes.windows(2) {
            if pair[0].0 == pair[1].0 && pair[0].1 == pair[1].1 {
                sets.join(pair[0].2, pair[1].2);
            }
        }
        let mut of_vertex = vec![NONE; mesh.vertex_count()];
        let mut first_vertex = Vec::new();
        for v in 0..mesh.vertex_count() as u32 {
            let root = sets.find(v) as usize;
            if of_vertex[root] == NONE {
                of_vertex[root] = first_vertex.len() as u32;
                first_vertex.push(v);
            }
            of_vertex[v as usize] = of_vertex[root];
        }
        Self { of_vertex, first_vertex }
    }

    /// Number of groups.
    #[must_use]
    pub fn len(&self) -> usize {
        self.first_vertex.len()
    }

    /// Returns whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.first_vertex.is_empty()
    }
}
