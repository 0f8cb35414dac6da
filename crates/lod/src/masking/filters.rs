//! Filters of strips in any state: the shortest one wherever it can be found, remembered by pattern.

use super::pattern::Pattern;
use super::shortest::Search;
use super::trim::trimmed;

/// How many patterns are remembered, by the lowest bits of their hashes.
const REMEMBERED: usize = 1 << 14;

/// Finds filters. What it remembers makes it faster, never different: a filter depends on the pattern alone.
pub(super) struct Filters {
    search: Search,
    known: Vec<([u128; 2], u32)>,
}

impl Filters {
    pub(super) fn new() -> Self {
        // No pattern has the key 0: there is the length in it.
        Self { search: Search::new(), known: vec![([0; 2], 0); REMEMBERED] }
    }

    /// The positions that are drawn: those of the shortest filter, if a bounded search finds it. 0 without live triangles.
    pub(super) fn filter(&mut self, pattern: &Pattern) -> u64 {
        let Some(key) = pattern.key() else { return self.find(pattern) };
        let slot = hash(key) % REMEMBERED;
        if self.known[slot].0 != key {
            // A pattern that has a key has at most 24 positions.
            self.known[slot] = (key, self.find(pattern) as u32);
        }
        u64::from(self.known[slot].1)
    }

    fn find(&mut self, pattern: &Pattern) -> u64 {
        self.search.shortest(pattern, Search::LIMIT).unwrap_or_else(|| trimmed(pattern))
    }
}

fn hash([labels, places]: [u128; 2]) -> usize {
    let fold = |n: u128| n as u64 ^ ((n >> 64) as u64).rotate_left(23);
    let mixed = (fold(labels) ^ fold(places).rotate_left(11)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed >> 40) as usize
}
