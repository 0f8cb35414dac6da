//! The local phase of Stripe: always continue with the neighbour that has the fewest neighbours
//! left.

use crate::adjacency::decode;
use crate::cover::{Cover, is_none};

/// The weight of a swap against one neighbour more or less.
const SWAP: u32 = 2;

/// Links triangles to strips, starting each at the triangle with the fewest neighbours left.
pub(crate) fn cover(cover: &mut Cover) {
    let mut greedy =
        Greedy { buckets: Default::default(), free: vec![0; cover.nodes.len()], cover };
    // Pushed in reverse, so that the first triangle lies on top.
    for t in (0..greedy.free.len() as u32).rev() {
        let n = &greedy.cover.nodes[t as usize][..3];
        let count = n.iter().filter(|&&c| !is_none(c)).count() as u32;
        greedy.free[t as usize] = count as u8;
        greedy.buckets[count as usize].push(t);
    }
    while let Some(start) = greedy.next_start() {
        greedy.take(start);
        greedy.extend(start);
        // Backwards from where it began, if something is left there.
        greedy.extend(start);
    }
}

/// `free` of a triangle in a strip.
const TAKEN: u8 = u8::MAX;

struct Greedy<'a> {
    cover: &'a mut Cover,
    /// Triangles by how many neighbours they have left. Outdated entries are skipped when they
    /// surface.
    buckets: [Vec<u32>; 4],
    free: Vec<u8>,
}

impl Greedy<'_> {
    fn next_start(&mut self) -> Option<u32> {
        for (count, bucket) in self.buckets.iter_mut().enumerate() {
            while let Some(t) = bucket.pop() {
                if self.free[t as usize] as usize == count {
                    return Some(t);
                }
            }
        }
        None
    }
    fn take(&mut self, t: u32) {
        self.free[t as usize] = TAKEN;
        for slot in 0..3 {
            if let Some(u) = self.free_neighbour(t, slot) {
                let free = &mut self.free[u as usize];
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
        (self.free[u as usize] != TAKEN).then_some(u)
    }
    /// Continues a strip at one of its ends for as long as there is a way.
    fn extend(&mut self, end: u32) {
        let mut at = end;
        while let Some(slot) = self.best(at) {
            let (next, _) = decode(self.cover.neighbour(at, slot));
            self.cover.toggle(at, slot);
            self.take(next);
            at = next;
        }
    }
    fn best(&self, at: u32) -> Option<u32> {
        let links = self.cover.links(at);
        let entered = (links != 0).then(|| links.trailing_zeros());
        let mut best = None;
        for slot in 0..3 {
            if links & 1 << slot != 0 {
                continue;
            }
            let Some(next) = self.free_neighbour(at, slot) else { continue };
            let swap = entered.is_some_and(|entered| {
                let (u, f) = decode(self.cover.neighbour(at, entered));
                self.cover.would_swap((slot + 3 - entered) % 3, u, f)
            });
            let score = u32::from(self.free[next as usize]) * 2 + u32::from(swap) * SWAP;
            let key = (score, swap, self.ahead(next), slot);
            if best.is_none_or(|b| key < b) {
                best = Some(key);
            }
        }
        best.map(|(.., slot)| slot)
    }
    /// The fewest neighbours left of any neighbour.
    fn ahead(&self, t: u32) -> u8 {
        (0..3)
            .filter_map(|slot| self.free_neighbour(t, slot))
            .map(|u| self.free[u as usize])
            .min()
            .unwrap_or(0)
    }
}
