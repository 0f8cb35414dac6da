//! Which repetitions a record takes out of a strip (thesis 3.3.3), with the winding of everything else kept.
//!
//! The thesis has two filters: a vertex repetition `a a (a)+` keeps two, an edge repetition `a b (a b)+` keeps one pair.
//! Taking out an even number of elements keeps the side of every later triangle, so the edge filter is always right,
//! and so is the vertex filter two at a time. A single element of `a a a` or `x a a x` turns over what is behind it. It
//! goes together with another one if no triangle is drawn between the two, or behind the last drawn triangle. There
//! `a a` and `a b a` lose one too, as long as those who meet then make no new triangle. Whether a triangle is drawn
//! is asked by position, whether elements repeat by vertex: refining puts them back by copying.

use super::working::WorkingStrip;

/// How far from a change partners of a single element are looked for.
const REACH: usize = 12;

/// How many changes a removal must spare. It takes two words itself and a change one, so this is where storage breaks even
/// (measured on bunny, cow and cessna: 2 to 4 give the same size within one percent, 2 draws least).
const LEAST: u32 = 2;

/// Consecutive elements that repeat the one (`period` 1) or two (2) before them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Repetition {
    pub(crate) first: u32,
    pub(crate) last: u32,
    pub(crate) count: u32,
    pub(crate) period: u32,
}

/// What one record takes out of one strip.
#[derive(Debug)]
pub(crate) struct Filter<'a> {
    pub(crate) gone: Vec<Repetition>,
    targets: &'a [u32],
    /// The record with which the strip dies.
    pub(crate) end: u32,
}

impl<'a> Filter<'a> {
    /// For strips of a mesh with these collapse targets.
    pub(crate) fn new(targets: &'a [u32]) -> Self {
        Self { gone: Vec::new(), targets, end: u32::MAX }
    }

    /// How many changes of a strip are spared if some elements go, up to [`LEAST`].
    fn worth(&self, strip: &WorkingStrip, first: u32, last: u32) -> u32 {
        let (mut e, mut worth) = (first, 0);
        loop {
            let mut v = strip.value(e);
            while v < self.end && worth < LEAST {
                (v, worth) = (self.targets[v as usize], worth + 1);
            }
            if e == last || worth >= LEAST {
                return worth;
            }
            e = strip.next(e);
        }
    }

    /// Takes repetitions around changed elements out of a strip. Afterwards `gone` has them in order; they neither
    /// touch nor rest on one another.
    pub(crate) fn apply(&mut self, strip: &mut WorkingStrip, changed: &[u32]) {
        self.gone.clear();
        for &element in changed {
            for second in [false, true] {
                if strip.is_left(element) {
                    let e = if second { strip.next(strip.next(element)) } else { element };
                    self.pairs(strip, e);
                }
            }
        }
        for &element in changed {
            if strip.is_left(element) {
                self.singles(strip, element);
            }
        }
        if changed.last().is_some_and(|&last| last >= strip.last_drawn()) {
            self.tail(strip);
        }
        self.gone.sort_unstable_by_key(|r| r.first);
    }

    /// The stretch of period two around an element: all pairs of it but the first.
    fn pairs(&mut self, strip: &mut WorkingStrip, element: u32) {
        if !strip.is_inside(element) || !strip.repeats(element, 2) {
            return;
        }
        let (mut first, mut last, mut count) = (element, element, 1);
        while strip.repeats(strip.previous(first), 2) {
            first = strip.previous(first);
            count += 1;
        }
        while strip.is_inside(strip.next(last)) && strip.repeats(strip.next(last), 2) {
            last = strip.next(last);
            count += 1;
        }
        if count % 2 == 1 {
            last = strip.previous(last);
            count -= 1;
        }
        if count > 0 {
            self.take(strip, first, last, count);
        }
    }

    /// Single elements, by twos, among triangles that are not drawn.
    fn singles(&mut self, strip: &mut WorkingStrip, element: u32) {
        let mut e = element;
        for _ in 0..2 {
            if strip.draws(e) {
                e = strip.previous(e);
            }
        }
        if strip.draws(e) {
            return;
        }
        for _ in 0..REACH {
            let before = strip.previous(e);
            if !strip.is_inside(before) || strip.draws(before) {
                break;
            }
            e = before;
        }
        let mut waiting = None;
        for _ in 0..2 * REACH {
            if !strip.is_inside(e) {
                break;
            }
            if strip.repeats(e, 1)
                && is_harmless(strip, e, e)
                && self.is_free(strip, e, e)
                && self.worth(strip, e, e) >= LEAST
            {
                if let Some(partner) = waiting {
                    if strip.previous(strip.previous(e)) > partner && self.is_free(strip, partner, partner) {
                        self.take(strip, partner, partner, 1);
                        self.take(strip, e, e, 1);
                    }
                    return;
                }
                waiting = Some(e);
            }
            if strip.draws(e) {
                return;
            }
            e = strip.next(e);
        }
    }

    /// Whatever repeats behind the last drawn triangle.
    fn tail(&mut self, strip: &mut WorkingStrip) {
        let third = strip.next(strip.next(strip.last_drawn()));
        let mut e = strip.next(third);
        for _ in 0..2 * REACH {
            if !strip.is_inside(e) {
                return;
            }
            let period = if strip.repeats(e, 1) { 1 } else { 2 };
            let (first, mut last, mut count) = (e, e, 0);
            while strip.is_inside(e) && strip.repeats(e, period) {
                (last, count) = (e, count + 1);
                e = strip.next(e);
            }
            if count > 0 && is_harmless(strip, first, last) {
                self.take(strip, first, last, count);
            } else if count == 0 {
                e = strip.next(e);
            }
        }
    }

    /// Whether nothing that this record takes out is among these elements or the two before them.
    fn is_free(&self, strip: &WorkingStrip, first: u32, last: u32) -> bool {
        let start = |first| strip.previous(strip.previous(first));
        self.gone.iter().all(|r| r.last < start(first) || last < start(r.first))
    }

    fn take(&mut self, strip: &mut WorkingStrip, first: u32, last: u32, count: u32) {
        if !self.is_free(strip, first, last) || self.worth(strip, first, last) < LEAST {
            return;
        }
        let (mut same, mut e) = (strip.repeats(first, 1), first);
        while e != last {
            e = strip.next(e);
            same &= strip.repeats(e, 1);
        }
        self.gone.push(Repetition { first, last, count, period: if same { 1 } else { 2 } });
        strip.unlink(first, last);
    }
}

/// Whether the elements that meet when some go make no triangle: by vertex, so that they never will.
fn is_harmless(strip: &WorkingStrip, first: u32, last: u32) -> bool {
    let (b, c) = (strip.previous(first), strip.next(last));
    let (a, d) = (strip.previous(b), strip.next(c));
    let flat = |e: [u32; 3]| {
        let [p, q, r] = e.map(|e| strip.value(e));
        !e.iter().all(|&e| strip.is_inside(e)) || p == q || q == r || r == p
    };
    flat([a, b, c]) && (strip.repeats(first, 1) || flat([b, c, d]))
}
