//! The tree of collapses in preorder: whatever becomes a vertex follows it in one run.

use std::ops::Range;

/// Entries whose maximum is stored as one, so that a search skips them at once. Chosen by hand.
const BLOCK: usize = 64;

/// The vertices in an order in which each is followed by all that become it, and the LOD at which
/// each loses its last triangle.
#[derive(Clone, Debug)]
pub(super) struct Tour {
    /// The place of each vertex, and the number of those that become it, itself included.
    places: Vec<[u32; 2]>,
    vertices: Vec<u32>,
    removal_lods: Vec<u32>,
    /// The highest removal LOD of each block, of each block of blocks and so on.
    highest: Vec<Vec<u32>>,
}

impl Tour {
    /// `targets` are those of a sequence, `removal_lods` say when each vertex loses its last
    /// triangle.
    pub(super) fn new(targets: &[u32], removal_lods: &[u32]) -> Self {
        let count = removal_lods.len();
        let mut places = vec![[0, 1]; count];
        for (vertex, &target) in targets.iter().enumerate() {
            places[target as usize][1] += places[vertex][1];
        }
        // Targets are higher than what becomes them: known first, if the highest comes first.
        let mut next = vec![1; count];
        for (vertex, &target) in targets.iter().enumerate().rev() {
            let place = next[target as usize];
            next[target as usize] += places[vertex][1];
            places[vertex][0] = place;
            next[vertex] = place + 1;
        }
        let mut vertices = vec![0; count];
        for (vertex, place) in (0..).zip(&places) {
            vertices[place[0] as usize] = vertex;
        }
        let removal_lods: Vec<u32> = vertices.iter().map(|&v| removal_lods[v as usize]).collect();
        let mut highest: Vec<Vec<u32>> = Vec::new();
        let mut below = &removal_lods;
        while below.len() > BLOCK {
            let of = |block: &[u32]| block.iter().copied().max().unwrap_or_default();
            highest.push(below.chunks(BLOCK).map(of).collect());
            below = &highest[highest.len() - 1];
        }
        Self { places, vertices, removal_lods, highest }
    }

    /// Calls `visit` with every vertex that is, or has become, a given one and has triangles at a
    /// LOD. What has none is passed over in blocks.
    pub(super) fn for_each_live(&self, vertex: u32, lod: u32, mut visit: impl FnMut(u32)) {
        let [first, count] = self.places[vertex as usize].map(|n| n as usize);
        let (mut at, end) = (first, first + count);
        while at < end {
            if self.removal_lods[at] > lod {
                visit(self.vertices[at]);
                at += 1;
            } else {
                at += self.dead(at..end, lod);
            }
        }
    }

    /// Returns a number of places from the first of some on, itself included, that have no
    /// triangles. It has none.
    fn dead(&self, places: Range<usize>, lod: u32) -> usize {
        let mut size = 1;
        for highest in &self.highest {
            let larger = size * BLOCK;
            let whole = places.start.is_multiple_of(larger) && places.start + larger <= places.end;
            if !whole || highest[places.start / larger] > lod {
                break;
            }
            size = larger;
        }
        size
    }
}
