//! An Euler tour of the tree of collapses: in preorder, the vertices that become a given one are
//! consecutive, so that all of them can be visited at once that still have triangles.

use std::ops::Range;

/// Number of entries that share one stored maximum, so that a search skips them at once. Chosen by
/// hand.
const BLOCK: usize = 64;

/// The vertices in an order in which each is followed by all that become it, and the LOD at which
/// each loses its last triangle.
#[derive(Clone, Debug)]
pub(super) struct Tour {
    /// For each vertex its index in `vertices`, and the number of vertices that become it, itself
    /// included.
    subtrees: Vec<[u32; 2]>,
    /// The vertices in preorder.
    vertices: Vec<u32>,
    /// The removal LODs of `vertices`.
    removal_lods: Vec<u32>,
    /// The highest removal LOD of each block, of each block of blocks and so on.
    highest: Vec<Vec<u32>>,
}

impl Tour {
    /// `targets` has for each vertex but the last, the root, the one that it becomes, which has a
    /// higher number; `removal_lods` say when each vertex loses its last
    /// triangle.
    pub(super) fn new(targets: &[u32], removal_lods: &[u32]) -> Self {
        let count = removal_lods.len();
        let mut subtrees = vec![[0, 1]; count];
        for (vertex, &target) in targets.iter().enumerate() {
            subtrees[target as usize][1] += subtrees[vertex][1];
        }
        // Targets have higher numbers than what becomes them, so their index is known first in
        // falling order.
        let mut next = vec![1; count];
        for (vertex, &target) in targets.iter().enumerate().rev() {
            let index = next[target as usize];
            next[target as usize] += subtrees[vertex][1];
            subtrees[vertex][0] = index;
            next[vertex] = index + 1;
        }
        let mut vertices = vec![0; count];
        for (vertex, index) in (0..).zip(&subtrees) {
            vertices[index[0] as usize] = vertex;
        }
        let removal_lods: Vec<u32> = vertices.iter().map(|&v| removal_lods[v as usize]).collect();
        let mut highest: Vec<Vec<u32>> = Vec::new();
        let mut level = &removal_lods;
        while level.len() > BLOCK {
            let maximum = |block: &[u32]| block.iter().copied().max().unwrap_or_default();
            highest.push(level.chunks(BLOCK).map(maximum).collect());
            level = &highest[highest.len() - 1];
        }
        Self { subtrees, vertices, removal_lods, highest }
    }

    /// Calls `visit` with every vertex that is, or has become, a given one and has triangles at a
    /// LOD. What has none is passed over in blocks.
    pub(super) fn for_each_live(&self, vertex: u32, lod: u32, mut visit: impl FnMut(u32)) {
        let [first, count] = self.subtrees[vertex as usize].map(|n| n as usize);
        let (mut current, end) = (first, first + count);
        while current < end {
            if self.removal_lods[current] > lod {
                visit(self.vertices[current]);
                current += 1;
            } else {
                current += self.dead_run(current..end, lod);
            }
        }
    }

    /// Returns the length of a run without triangles at the start of some indices, of which the
    /// first has none: one, or whole blocks.
    fn dead_run(&self, indices: Range<usize>, lod: u32) -> usize {
        let mut size = 1;
        for highest in &self.highest {
            let larger = size * BLOCK;
            let whole =
                indices.start.is_multiple_of(larger) && indices.start + larger <= indices.end;
            if !whole || highest[indices.start / larger] > lod {
                break;
            }
            size = larger;
        }
        size
    }
}
