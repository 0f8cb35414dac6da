//! The filter of a strip in any state: the shortest one if a bounded search finds it, else a
//! trimmed one. Results are cached by pattern.

use super::pattern::{Pattern, PatternKey};
use super::shortest::Search;
use super::trim::trimmed;

/// Number of patterns that are remembered, by the lowest bits of their hashes: half a megabyte for
/// each thread. Chosen by hand.
const CACHE_ENTRIES: usize = 1 << 14;

/// Finds filters. The cache changes the time, never the result: a filter depends on the
/// pattern alone.
pub(super) struct Filters {
    search: Search,
    /// Patterns, by their keys, and their filters.
    cache: Vec<(PatternKey, u16)>,
}

impl Filters {
    pub(super) fn new() -> Self {
        Self { search: Search::new(), cache: vec![(PatternKey::NONE, 0); CACHE_ENTRIES] }
    }

    /// Returns the positions that are drawn: those of the shortest filter, if a bounded search
    /// finds it; 0 without live triangles.
    pub(super) fn filter(&mut self, pattern: &Pattern) -> u16 {
        let key = pattern.key();
        let entry = key.hash() % CACHE_ENTRIES;
        if self.cache[entry].0 != key {
            let mask =
                self.search.shortest(pattern, Search::LIMIT).unwrap_or_else(|| trimmed(pattern));
            self.cache[entry] = (key, mask as u16);
        }
        self.cache[entry].1
    }
}
