//! The first appearance of each triangle in the stream: with which vertex it comes, and between
//! which vertices it lies then. They are those that it has in the collapse sequence just before its
//! removal.

use lodc_mesh::{Csr, Simplified, removal_lods};

/// A triangle of the mesh as it first appears in the stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct FirstAppearance {
    /// Its vertices in stream order, counter-clockwise from the one that it comes with.
    pub(crate) vertices: [u32; 3],
    /// Index of that corner in the mesh's triangle, 0 to 2.
    pub(crate) rotation: usize,
}

/// Resolves vertices through the collapses before a LOD; the LOD must not fall from call to call.
///
/// Paths of collapses are compressed as they are walked, so any number of calls takes near-linear
/// time (Tarjan 1975).
struct Resolver {
    /// For each vertex one that it has become: at first its target.
    next: Vec<u32>,
}

impl Resolver {
    fn new(simplified: &Simplified) -> Self {
        let collapses = simplified.collapses();
        let mut next = collapses.targets().to_vec();
        next.push(collapses.records());
        Self { next }
    }

    /// Returns what a vertex has become at a LOD, which must not be below that of the call before.
    fn resolve(&mut self, vertex: u32, lod: u32) -> u32 {
        let mut root = vertex;
        while root < lod {
            root = self.next[root as usize];
        }
        let mut v = vertex;
        while v < lod {
            v = std::mem::replace(&mut self.next[v as usize], root);
        }
        root
    }
}

/// Returns the first appearance of each triangle, in near-linear time for any sequence.
///
/// A triangle that the step from LOD s to LOD r removes appears in the stream with the first of its
/// vertices that this step removes, and with the vertices that it has at LOD s.
pub(crate) fn first_appearances(simplified: &Simplified) -> Vec<FirstAppearance> {
    let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
    let last = collapses.records();
    let removal = removal_lods(simplified, &mesh.position_ids());
    let by_removal = Csr::new(last as usize + 1, removal.into_iter().zip(0..));
    let mut resolver = Resolver::new(simplified);
    let mut appearances = vec![FirstAppearance::default(); mesh.triangles().len()];
    let mut start = 0;
    for &end in &collapses.parts().step_ends {
        for &triangle in by_removal.row(end) {
            let vertices = mesh.triangles()[triangle as usize].map(|v| resolver.resolve(v, start));
            let rotation = (0..3).min_by_key(|&i| vertices[i]).unwrap_or_default();
            appearances[triangle as usize] = FirstAppearance {
                vertices: std::array::from_fn(|i| last - vertices[(rotation + i) % 3]),
                rotation,
            };
        }
        start = end;
    }
    appearances
}
