//! A filter that is found in bounded time and not always the shortest: for strips whose shortest
//! filter is too hard to find.
//!
//! The patterns of the thesis (4.2.2): triangles that share an edge follow each other directly,
//! those that share a vertex or nothing are connected by the fewest degenerate triangles that the
//! strip has there, and both ends are trimmed.

use super::pattern::Pattern;

/// The positions of a filter that draws exactly the live triangles; 0 if there are none. Takes time
/// quadratic in the length of the strip.
pub(super) fn trimmed(pattern: &Pattern) -> u64 {
    let labels = pattern.labels();
    let live =
        |k: usize| pattern.triangle([labels[k], labels[k + 1], labels[k + 2]], false).is_some();
    let Some(first) = (0..labels.len() - 2).find(|&k| live(k)) else { return 0 };
    let last = (0..labels.len() - 2).rfind(|&k| live(k)).unwrap_or(first);
    // An even number goes from the start, so that everything keeps its orientation.
    let mut kept: Vec<usize> = (first & !1..last + 3).collect();
    while let Some(at) = superfluous_pair(pattern, &kept) {
        kept.drain(at..at + 2);
    }
    kept.iter().fold(0, |mask, &at| mask | 1 << at)
}

/// The first two neighbours in `kept` that can be left out: the same triangles are drawn without
/// them.
fn superfluous_pair(pattern: &Pattern, kept: &[usize]) -> Option<usize> {
    let label = |i: usize| pattern.labels()[kept[i]];
    let drawn = |i: [usize; 3], first: usize| pattern.triangle(i.map(label), first % 2 == 1);
    (0..kept.len() - 1).find(|&pair| {
        // Triangles are numbered by their first corner among the kept positions.
        let (from, to) = (pair.saturating_sub(2), (pair + 2).min(kept.len() - 2));
        let drawn_with = (from..to).filter_map(|k| drawn([k, k + 1, k + 2], k));
        let skip = |i: usize| if i < pair { i } else { i + 2 };
        let end = pair.min(kept.len().saturating_sub(4));
        let drawn_without =
            (from..end).filter_map(|k| drawn([skip(k), skip(k + 1), skip(k + 2)], k));
        drawn_with.eq(drawn_without)
    })
}
