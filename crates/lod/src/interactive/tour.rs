//! An Euler tour of the tree of collapses: in preorder, the vertices that become a given one are
//! consecutive, so that all of them can be visited at once that still have triangles.

use std::ops::Range;

/// Number of entries that share one stored maximum, so that a search skips them at once. Chosen by
/// hand.
const BLOCK_ENTRIES: usize = 64;

/// The vertices in an order in which each is followed by all that become it, and the LOD at which
/// each loses its last triangle.
#[derive(Clone, Debug)]
pub(super) struct Tour {
    /// For each vertex the part of `vertices` that is it and all that become it.
    subtrees: Vec<Subtree>,
    /// The vertices in preorder.
    vertices: Vec<u32>,
    /// The removal LODs of `vertices`.
    removal_lods: Vec<u32>,
    /// The highest removal LOD of each block, of each block of blocks and so on.
    block_maxima: Vec<Vec<u32>>,
}

/// Consecutive vertices of a tour.
#[derive(Clone, Copy, Debug)]
struct Subtree {
    first: u32,
    count: u32,
}

impl Tour {
    /// `targets` has for each vertex but the last, the root, the one that it becomes, which has a
    /// higher number; `removal_lods` say when each vertex loses its last
    /// triangle.
    pub(super) fn new(targets: &[u32], removal_lods: &[u32]) -> Self {
        let count = removal_lods.len();
        let mut subtrees = vec![Subtree { first: 0, count: 1 }; count];
        for (vertex, &target) in targets.iter().enumerate() {
            subtrees[target as usize].count += subtrees[vertex].count;
        }
        // Targets have higher numbers than what becomes them: in falling order they come first.
        let mut next_child = vec![1; count];
        for (vertex, &target) in targets.iter().enumerate().rev() {
            let first = next_child[target as usize];
            next_child[target as usize] += subtrees[vertex].count;
            subtrees[vertex].first = first;
            next_child[vertex] = first + 1;
        }
        let mut vertices = vec![0; count];
        for (vertex, subtree) in (0..).zip(&subtrees) {
            vertices[subtree.first as usize] = vertex;
        }
        let removal_lods: Vec<u32> = vertices.iter().map(|&v| removal_lods[v as usize]).collect();
        let mut block_maxima: Vec<Vec<u32>> = Vec::new();
        let mut below = &removal_lods;
        while below.len() > BLOCK_ENTRIES {
            let maximum = |block: &[u32]| block.iter().copied().max().unwrap_or_default();
            block_maxima.push(below.chunks(BLOCK_ENTRIES).map(maximum).collect());
            below = &block_maxima[block_maxima.len() - 1];
        }
        Self { subtrees, vertices, removal_lods, block_maxima }
    }

    /// Calls `visit` with every vertex that is, or has become, a given one and has triangles at a
    /// LOD. What has none is passed over in blocks.
    pub(super) fn for_each_live(&self, vertex: u32, lod: u32, mut visit: impl FnMut(u32)) {
        let Subtree { first, count } = self.subtrees[vertex as usize];
        let (mut current, end) = (first as usize, (first + count) as usize);
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
        for maxima in &self.block_maxima {
            let larger = size * BLOCK_ENTRIES;
            let is_whole =
                indices.start.is_multiple_of(larger) && indices.start + larger <= indices.end;
            if !is_whole || maxima[indices.start / larger] > lod {
                break;
            }
            size = larger;
        }
        size
    }
}
