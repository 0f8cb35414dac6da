//! Filters of strips in any state: the shortest one wherever it can be found, remembered by
//! pattern.

use super::pattern::Pattern;
use super::shortest::Search;
use super::trim::trimmed;

/// Number of patterns that are remembered, by the lowest bits of their hashes: half a megabyte for
/// each thread. Chosen by hand.
const REMEMBERED: usize = 1 << 14;

/// Finds filters. What it remembers makes it faster, never different: a filter depends on the
/// pattern alone.
pub(super) struct Filters {
    search: Search,
    known: Vec<((u64, u64, usize), u16)>,
}

impl Filters {
    pub(super) fn new() -> Self {
        // No pattern has the length 0.
        Self { search: Search::new(), known: vec![((0, 0, 0), 0); REMEMBERED] }
    }

    /// The positions that are drawn: those of the shortest filter, if a bounded search finds it. 0
    /// without live triangles.
    pub(super) fn filter(&mut self, pattern: &Pattern) -> u16 {
        let key = pattern.key();
        let slot = hash(key) % REMEMBERED;
        if self.known[slot].0 != key {
            let found =
                self.search.shortest(pattern, Search::LIMIT).unwrap_or_else(|| trimmed(pattern));
            self.known[slot] = (key, found as u16);
        }
        self.known[slot].1
    }
}

fn hash((labels, places, length): (u64, u64, usize)) -> usize {
    let mixed =
        (labels ^ places.rotate_left(11) ^ length as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed >> 40) as usize
}
