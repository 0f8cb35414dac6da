//! Filters: examples, all subsequences of small strips, patterns in disguise, and what is not the
//! shortest.

use super::super::{filters::Filters, pattern::Pattern, shortest::Search, trim::trimmed};
use super::*;

fn plain(strip: &[u32]) -> Pattern {
    Pattern::new(strip, |v| v)
}

/// The triangles of a filter, to be compared with those of the whole strip.
fn drawn(pattern: &Pattern, mask: u64) -> Vec<[u8; 3]> {
    let mut triangles: Vec<_> = pattern.drawn(mask).collect();
    triangles.sort_unstable();
    triangles
}

/// Returns the triangles of a strip, straight from the definition: window by window, by vertex and
/// position.
fn naive(strip: &[u32], position_of: impl Fn(u32) -> u32) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for k in 0..strip.len().saturating_sub(2) {
        let mut t = [strip[k], strip[k + 1], strip[k + 2]];
        let [a, b, c] = t.map(&position_of);
        if a != b && b != c && c != a {
            if k % 2 == 1 {
                t.swap(0, 1);
            }
            triangles.push(OrientedTriangle::new(0, t).corners);
        }
    }
    triangles.sort_unstable();
    triangles
}

fn choose(strip: &[u32], mask: u64) -> Vec<u32> {
    (0..strip.len()).filter(|at| mask >> at & 1 == 1).map(|at| strip[at]).collect()
}

/// The fewest positions that draw the same, by trying all subsequences.
fn brute_force(strip: &[u32], position_of: impl Fn(u32) -> u32 + Copy) -> u32 {
    let wanted = naive(strip, position_of);
    let masks =
        (0..1u64 << strip.len()).filter(|&mask| naive(&choose(strip, mask), position_of) == wanted);
    masks.map(u64::count_ones).min().expect("the whole strip draws what it draws")
}

#[test]
fn filters_worked_out_by_hand() {
    let all = |strip: &[u32]| {
        let pattern = plain(strip);
        bits(
            Search::new().shortest(&pattern, Search::LIMIT).expect("a small strip") as u16,
            strip.len(),
        )
    };
    // Nothing to leave out; nothing left to draw.
    assert_eq!(all(&[1, 2, 3, 4]), "1111");
    assert_eq!(all(&[1, 2, 2, 1, 2]), "00000");
    // Ends that draw nothing: an even number may go at the start.
    assert_eq!(all(&[4, 4, 1, 1, 1, 2, 3, 3, 3]).matches('1').count(), 3);
    // An odd number may not, so one stays to turn the triangle; either will do.
    assert_eq!(Search::new().shortest(&plain(&[1, 1, 2, 3]), 100).map(u64::count_ones), Some(4));
    // A vertex repeated twice over, and an edge repeated.
    assert_eq!(all(&[1, 2, 3, 3, 3, 3, 3, 4, 5]).matches('1').count(), 7);
    assert_eq!(all(&[1, 2, 3, 2, 3, 4]).matches('1').count(), 4);
    // One swap has to stay.
    assert_eq!(all(&[1, 2, 0, 3, 0, 4, 5]), "1111111");
}

#[test]
fn no_subsequence_is_shorter_than_the_shortest_filter() {
    let mut rng = fixtures::Rng::new(11);
    let (mut search, mut filters) = (Search::new(), Filters::new());
    for case in 0..6000 {
        let len = 3 + rng.below(9);
        let vertices = 2 + rng.below(len);
        let strip: Vec<u32> = match case % 3 {
            0 => (0..len).map(|_| rng.below(vertices) as u32).collect(),
            // What collapses make of a strip without repetitions, and of one with turns.
            _ => {
                let mut strip: Vec<u32> = Vec::new();
                for k in 0..len {
                    let turn = case % 3 == 1 && k > 1 && rng.one_in(4);
                    strip.push(if turn { strip[k - 2] } else { k as u32 });
                }
                for _ in 0..rng.below(len) {
                    let (from, to) = (rng.pick(&strip), rng.pick(&strip));
                    strip.iter_mut().filter(|v| **v == from).for_each(|v| *v = to);
                }
                strip
            }
        };
        // Sometimes several vertices are at one position.
        let positions = if rng.one_in(2) { u32::MAX } else { 2 + rng.below(6) as u32 };
        let position_of = |v: u32| v % positions;
        let pattern = Pattern::new(&strip, position_of);
        let mask = search.shortest(&pattern, Search::LIMIT).expect("few states");
        let wanted = naive(&strip, position_of);
        if wanted.is_empty() {
            assert_eq!((mask, trimmed(&pattern)), (0, 0), "{strip:?}");
            continue;
        }
        assert_eq!(
            naive(&choose(&strip, mask), position_of),
            wanted,
            "{strip:?}, {positions} positions"
        );
        assert_eq!(
            mask.count_ones(),
            brute_force(&strip, position_of),
            "{strip:?}, {positions} positions"
        );
        assert_eq!(u64::from(filters.filter(&pattern)), mask, "{strip:?}");
        let other = trimmed(&pattern);
        assert_eq!(
            naive(&choose(&strip, other), position_of),
            wanted,
            "{strip:?}, {positions} positions"
        );
    }
}

#[test]
fn strips_around_hubs_draw_exactly_their_triangles_however_they_are_filtered() {
    let mut rng = fixtures::Rng::new(5);
    let mut search = Search::new();
    for case in 0..600 {
        let len = 12 + rng.below(5);
        // Fans around few high-valence vertices, or bands.
        let centers = 1 + rng.below(3) as u32;
        let fan = rng.one_in(2);
        let mut strip: Vec<u32> = (0..len as u32)
            .map(|k| if fan && k % 2 == 0 { 1000 + k / 5 % centers } else { k })
            .collect();
        for _ in 0..rng.below(len) {
            let at = rng.below(len - 1);
            let (from, to) = (strip[at], strip[at + 1]);
            strip.iter_mut().filter(|v| **v == from).for_each(|v| *v = to);
        }
        let pattern = plain(&strip);
        let wanted = drawn(&pattern, pattern.all());
        let other = trimmed(&pattern);
        assert_eq!(drawn(&pattern, other), wanted, "{case}: {strip:?}");
        let shortest = search.shortest(&pattern, Search::LIMIT);
        if let Some(mask) = shortest {
            assert_eq!(drawn(&pattern, mask), wanted, "{case}: {strip:?}");
            assert!(mask.count_ones() <= other.count_ones(), "{case}: {strip:?}");
        }
        // A search that must not look at anything gives up; the filter is still right.
        if shortest.is_some_and(|mask| mask != 0 && mask != pattern.all()) {
            assert_eq!(search.shortest(&pattern, 0), None);
        }
    }
}

/// Trimming cannot move a swap, but both ends and repetitions go.
#[test]
fn trimming_follows_the_patterns_of_the_thesis() {
    let trim = |strip: &[u32]| bits(trimmed(&plain(strip)) as u16, strip.len());
    assert_eq!(trim(&[4, 4, 1, 1, 1, 2, 3, 3, 3]), "000011100");
    assert_eq!(trim(&[1, 1, 2, 3]), "1111");
    assert_eq!(trim(&[1, 2, 3, 3, 3, 3, 3, 4, 5]).matches('1').count(), 7);
    assert_eq!(trim(&[1, 2, 3, 2, 3, 4]).matches('1').count(), 4);
    // Two triangles that share nothing: two vertices repeated, as many as there must be.
    assert_eq!(trim(&[1, 2, 3, 3, 3, 3, 4, 4, 5, 6]).matches('1').count(), 8);
}
