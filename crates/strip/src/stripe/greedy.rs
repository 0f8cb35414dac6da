//! The greedy phase of Stripe (Evans, Skiena and Varshney 1996): a strip always goes on to the
//! neighbour that itself has the fewest free neighbours, so that no triangle is left isolated.

use crate::adjacency::decode;
use crate::cover::{Cover, is_none};

/// The weight of a swap, which costs an index, against one free neighbour more or less, which
/// counts 2. Chosen by hand.
const SWAP_WEIGHT: u32 = 2;

/// Links triangles to strips, starting each at the triangle with the fewest neighbours left.
pub(crate) fn cover(cover: &mut Cover) {
    let mut greedy =
        Greedy { buckets: Default::default(), free_neighbours: vec![0; cover.nodes.len()], cover };
    // Pushed in reverse, so that the first triangle lies on top.
    for t in (0..greedy.free_neighbours.len() as u32).rev() {
        let neighbours = &greedy.cover.nodes[t as usize][..3];
        let count = neighbours.iter().filter(|&&c| !is_none(c)).count() as u32;
        greedy.free_neighbours[t as usize] = count as u8;
        greedy.buckets[count as usize].push(t);
    }
    while let Some(start) = greedy.next_start() {
        greedy.add_to_strip(start);
        greedy.extend(start);
        // A second time from the same triangle: backwards, if it has another free neighbour.
        greedy.extend(start);
    }
}

/// The value of `free_neighbours` for a triangle that is in a strip.
const IN_STRIP: u8 = u8::MAX;

struct Greedy<'a> {
    cover: &'a mut Cover,
    /// Triangles by their number of free neighbours. Entries are not moved when it falls; those
    /// that are out of date are skipped when they are taken.
    buckets: [Vec<u32>; 4],
    /// Number of free neighbours of each triangle.
    free_neighbours: Vec<u8>,
}

impl Greedy<'_> {
    /// The free triangle with the fewest free neighbours.
    fn next_start(&mut self) -> Option<u32> {
        for (count, bucket) in self.buckets.iter_mut().enumerate() {
            while let Some(t) = bucket.pop() {
                if self.free_neighbours[t as usize] as usize == count {
                    return Some(t);
                }
            }
        }
        None
    }
    /// Puts a triangle into a strip: it is no free neighbour any more.
    fn add_to_strip(&mut self, t: u32) {
        self.free_neighbours[t as usize] = IN_STRIP;
        for slot in 0..3 {
            if let Some(u) = self.free_neighbour(t, slot) {
                let free = &mut self.free_neighbours[u as usize];
                // Doubled edges count twice: never below zero.
                *free = free.saturating_sub(1);
                self.buckets[*free as usize].push(u);
            }
        }
    }
    fn free_neighbour(&self, t: u32, slot: u32) -> Option<u32> {
        let c = self.cover.neighbour(t, slot);
        if is_none(c) {
            return None;
        }
        let (u, _) = decode(c);
        (self.free_neighbours[u as usize] != IN_STRIP).then_some(u)
    }
    /// Continues a strip at one of its ends until that has no free neighbour.
    fn extend(&mut self, end: u32) {
        let mut current = end;
        while let Some(slot) = self.best_exit(current) {
            let (next, _) = decode(self.cover.neighbour(current, slot));
            self.cover.toggle(current, slot);
            self.add_to_strip(next);
            current = next;
        }
    }
    /// The slot of the neighbour to continue with: the one with the fewest free neighbours, a swap
    /// counted in.
    fn best_exit(&self, current: u32) -> Option<u32> {
        let links = self.cover.links(current);
        let entered = (links != 0).then(|| links.trailing_zeros());
        let mut best_exit = None;
        for slot in 0..3 {
            if links & 1 << slot != 0 {
                continue;
            }
            let Some(next) = self.free_neighbour(current, slot) else { continue };
            let swap = entered.is_some_and(|entered| {
                let (u, f) = decode(self.cover.neighbour(current, entered));
                self.cover.would_swap((slot + 3 - entered) % 3, u, f)
            });
            let score =
                u32::from(self.free_neighbours[next as usize]) * 2 + u32::from(swap) * SWAP_WEIGHT;
            let key = (score, swap, self.fewest_beyond(next), slot);
            if best_exit.is_none_or(|b| key < b) {
                best_exit = Some(key);
            }
        }
        best_exit.map(|(.., slot)| slot)
    }
    /// The least number of free neighbours of any free neighbour.
    fn fewest_beyond(&self, t: u32) -> u8 {
        (0..3)
            .filter_map(|slot| self.free_neighbour(t, slot))
            .map(|u| self.free_neighbours[u as usize])
            .min()
            .unwrap_or(0)
    }
}
