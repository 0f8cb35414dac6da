//! Chooses the repetitions that a record removes from a strip (thesis 3.3.3) so that the winding of
//! all other triangles is kept.
//!
//! The thesis has two filters: a vertex repetition `a a (a)+` keeps two, an edge repetition `a b (a
//! b)+` keeps one pair. Removing an even number of elements keeps the side of every later triangle,
//! so the edge filter is always right, and so is the vertex filter two at a time. A single element
//! of `a a a` or `x a a x` turns over what is behind it. It is removed together with another one if
//! no triangle is drawn between the two. Whether a triangle is drawn is asked by position, whether
//! elements repeat by vertex: refining puts them back by copying.
//!
//! Beyond the thesis, the dead ends of a strip are removed, whatever they are: what comes before
//! its first drawn triangle (an even number, again for the winding) and after its last. They stay
//! in the buffer and come back by moving the ends (bunny: 497 bits per vertex without, 463 with).

use super::history::RemovalKind;
use super::tracer::RemovalSource;
use super::working::{RemovedRun, WorkingStrip};
use lodc_mesh::{NONE, is_degenerate};
use lodc_model::BuildError;

/// Elements on either side of a change among which a single element and its partner are looked for.
/// Between the two no triangle is drawn, so in real strips partners are next to each other; the
/// limit keeps a strip of nothing but repetitions from taking quadratic time. Chosen by hand.
const MAX_DISTANCE: usize = 12;

/// The least number of later changes that a removal must spare. It takes two words itself and a
/// change one, so this saves storage (bunny and cow: 2 to 4 give the same size within one percent;
/// it is removals that take time, changes hardly do).
const MIN_SPARED_CHANGES: u32 = 3;

/// The choice of what one record removes from one strip.
#[derive(Debug)]
pub(crate) struct Filter<'a> {
    pub(crate) removed: Vec<RemovedRun>,
    targets: &'a [u32],
    with_dead_ends: bool,
    /// The record with which the strip dies.
    pub(crate) last_record: u32,
}

impl<'a> Filter<'a> {
    /// For strips of a mesh with these collapse targets.
    pub(crate) fn new(targets: &'a [u32], with_dead_ends: bool) -> Self {
        Self { removed: Vec::new(), targets, with_dead_ends, last_record: NONE }
    }

    /// Returns the number of changes of a strip that are spared if some elements are removed, up to
    /// [`MIN_SPARED_CHANGES`].
    fn spared_changes(&self, strip: &WorkingStrip, first: u32, last: u32) -> u32 {
        let (mut e, mut spared_changes) = (first, 0);
        loop {
            let mut v = strip.value(e);
            // Record v collapses vertex v.
            while v < self.last_record && spared_changes < MIN_SPARED_CHANGES {
                (v, spared_changes) = (self.targets[v as usize], spared_changes + 1);
            }
            if e == last || spared_changes >= MIN_SPARED_CHANGES {
                return spared_changes;
            }
            e = strip.next(e);
        }
    }

    /// Removes repetitions around changed elements from a strip. Afterwards `removed` has them in
    /// order; none touches another or repeats its elements.
    pub(crate) fn apply(&mut self, strip: &mut WorkingStrip, changed: &[u32]) {
        self.removed.clear();
        if self.with_dead_ends {
            self.remove_dead_ends(strip);
        }
        for &element in changed {
            // It may repeat the element two before it, or the one two after may repeat it.
            for is_second_after in [false, true] {
                if strip.remains(element) {
                    let second_after = strip.next(strip.next(element));
                    self.remove_pairs(strip, if is_second_after { second_after } else { element });
                }
            }
        }
        for &element in changed {
            if strip.remains(element) {
                self.remove_singles(strip, element);
            }
        }
        self.removed.sort_unstable_by_key(|r| r.first);
    }

    /// Removes the stretch of period two around an element: all pairs of it but the first.
    fn remove_pairs(&mut self, strip: &mut WorkingStrip, element: u32) {
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
            self.remove(strip, first, last, count);
        }
    }

    /// Removes single elements, by twos, among triangles that are not drawn.
    fn remove_singles(&mut self, strip: &mut WorkingStrip, element: u32) {
        let mut e = element;
        for _ in 0..2 {
            if strip.draws(e) {
                e = strip.previous(e);
            }
        }
        if strip.draws(e) {
            return;
        }
        for _ in 0..MAX_DISTANCE {
            let previous = strip.previous(e);
            if !strip.is_inside(previous) || strip.draws(previous) {
                break;
            }
            e = previous;
        }
        let mut first_single = None;
        for _ in 0..2 * MAX_DISTANCE {
            if !strip.is_inside(e) {
                break;
            }
            if strip.repeats(e, 1)
                && is_harmless(strip, e)
                && self.is_apart(strip, e, e)
                && self.spared_changes(strip, e, e) >= MIN_SPARED_CHANGES
            {
                if let Some(partner) = first_single {
                    if strip.previous(strip.previous(e)) > partner
                        && self.is_apart(strip, partner, partner)
                    {
                        self.remove(strip, partner, partner, 1);
                        self.remove(strip, e, e, 1);
                    }
                    return;
                }
                first_single = Some(e);
            }
            if strip.draws(e) {
                return;
            }
            e = strip.next(e);
        }
    }

    /// Removes all that comes before the first drawn triangle and after the last.
    fn remove_dead_ends(&mut self, strip: &mut WorkingStrip) {
        let (front, mut e, mut count) = (strip.front(), strip.first_drawn(), 0);
        while e != front {
            (e, count) = (strip.previous(e), count + 1);
        }
        let mut last = strip.previous(strip.first_drawn());
        if count % 2 == 1 {
            (last, count) = (strip.previous(last), count - 1);
        }
        if count > 0 && self.spared_changes(strip, front, last) >= MIN_SPARED_CHANGES {
            self.removed.push(RemovedRun { first: front, last, count, kind: RemovalKind::Front });
            strip.unlink(front, last);
        }
        let (first, back) = (strip.next(strip.last_corner()), strip.back());
        if strip.is_inside(first) && self.spared_changes(strip, first, back) >= MIN_SPARED_CHANGES {
            let (mut e, mut count) = (first, 1);
            while e != back {
                (e, count) = (strip.next(e), count + 1);
            }
            self.removed.push(RemovedRun { first, last: back, count, kind: RemovalKind::Back });
            strip.unlink(first, back);
        }
    }

    /// Returns whether some elements and the two before them are apart from all that this record
    /// removes and the two before that.
    fn is_apart(&self, strip: &WorkingStrip, first: u32, last: u32) -> bool {
        let start = |first| strip.previous(strip.previous(first));
        self.removed.iter().all(|r| r.last < start(first) || last < start(r.first))
    }

    fn remove(&mut self, strip: &mut WorkingStrip, first: u32, last: u32, count: u32) {
        if !self.is_apart(strip, first, last)
            || self.spared_changes(strip, first, last) < MIN_SPARED_CHANGES
        {
            return;
        }
        let (mut is_vertex_repetition, mut e) = (strip.repeats(first, 1), first);
        while e != last {
            e = strip.next(e);
            is_vertex_repetition &= strip.repeats(e, 1);
        }
        self.removed.push(RemovedRun {
            first,
            last,
            count,
            kind: if is_vertex_repetition { RemovalKind::Vertex } else { RemovalKind::Edge },
        });
        strip.unlink_repetition(first, last);
    }
}

impl RemovalSource for Filter<'_> {
    const NEEDS_LAST_RECORD: bool = true;

    fn begin_strip(&mut self, last_record: u32) {
        self.last_record = last_record;
    }

    fn next_removals(
        &mut self,
        strip: &mut WorkingStrip,
        changed: &[u32],
    ) -> Result<&[RemovedRun], BuildError> {
        self.apply(strip, changed);
        Ok(&self.removed)
    }
}

/// Returns whether the elements that meet when a repeating one is removed make no triangle: by
/// vertex, so that they never will.
fn is_harmless(strip: &WorkingStrip, element: u32) -> bool {
    let (previous, next) = (strip.previous(element), strip.next(element));
    let [a, b, c] = [strip.previous(previous), previous, next].map(|e| strip.value(e));
    !strip.is_inside(strip.previous(previous)) || !strip.is_inside(next) || is_degenerate([a, b, c])
}
