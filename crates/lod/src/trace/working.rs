//! One strip while its history is worked out: a linked list, so that removing an element costs the
//! same anywhere.

use super::history::Kind;
use super::ranks::Ranks;
use lodc_mesh::{NONE, PositionIds, is_degenerate};

/// Sentinels before the strip, and as many after it, so that every element has two neighbours on
/// each side. Their values differ from each other and from every vertex.
const EDGE: u32 = 2;

/// Consecutive elements that a record removes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaving {
    pub(crate) first: u32,
    pub(crate) last: u32,
    pub(crate) count: u32,
    pub(crate) kind: Kind,
}

/// A strip at some LOD. Elements are numbered as in the strip of LOD 0.
#[derive(Clone, Debug, Default)]
pub(crate) struct WorkingStrip {
    value: Vec<u32>,
    previous: Vec<u32>,
    next: Vec<u32>,
    /// For each element whether it has not been removed.
    remaining: Vec<bool>,
    /// True if the triangle that starts at each element is drawn. Once it is not, it never is
    /// again.
    draws: Vec<bool>,
    /// Number of drawn triangles.
    drawn: u32,
    /// No triangle that starts behind this element is drawn.
    last_drawn: u32,
    /// No triangle that starts before this element is drawn.
    first_drawn: u32,
    /// Number of elements removed at the front.
    room: u32,
    ranks: Ranks,
}

impl WorkingStrip {
    /// Starts with a strip of LOD 0.
    pub(crate) fn start(&mut self, strip: &[u32], positions: &PositionIds) {
        let count = strip.len() as u32 + 2 * EDGE;
        self.value.clear();
        self.value.extend([NONE, NONE - 1]);
        self.value.extend_from_slice(strip);
        self.value.extend([NONE - 2, NONE - 3]);
        self.previous.clear();
        self.previous.extend((0..count).map(|i| i.saturating_sub(1)));
        self.next.clear();
        self.next.extend((0..count).map(|i| (i + 1).min(count - 1)));
        self.remaining.clear();
        self.remaining.resize(count as usize, true);
        self.ranks.fill(count as usize);
        self.draws.clear();
        self.draws.resize(count as usize, false);
        (self.drawn, self.first_drawn, self.last_drawn, self.room) = (0, count, 0, 0);
        for (i, w) in strip.windows(3).enumerate() {
            let corners = [w[0], w[1], w[2]].map(|v| positions.of_vertex[v as usize]);
            if !is_degenerate(corners) {
                self.draws[i + EDGE as usize] = true;
                self.drawn += 1;
                self.first_drawn = self.first_drawn.min(i as u32 + EDGE);
                self.last_drawn = i as u32 + EDGE;
            }
        }
    }

    /// The element that was number `i` of the strip of LOD 0.
    pub(crate) fn element(i: usize) -> u32 {
        i as u32 + EDGE
    }
    /// The inverse of [`Self::element`].
    pub(crate) fn number(element: u32) -> usize {
        (element - EDGE) as usize
    }
    pub(crate) fn remains(&self, element: u32) -> bool {
        self.remaining[element as usize]
    }
    /// Returns whether any triangle is drawn.
    pub(crate) fn is_live(&self) -> bool {
        self.drawn > 0
    }
    pub(crate) fn value(&self, element: u32) -> u32 {
        self.value[element as usize]
    }
    pub(crate) fn previous(&self, element: u32) -> u32 {
        self.previous[element as usize]
    }
    pub(crate) fn next(&self, element: u32) -> u32 {
        self.next[element as usize]
    }
    /// Returns whether the triangle that starts here is drawn.
    pub(crate) fn draws(&self, element: u32) -> bool {
        self.draws[element as usize]
    }
    /// Returns whether this element is one of the strip, not a sentinel.
    pub(crate) fn is_inside(&self, element: u32) -> bool {
        element >= EDGE && element < self.value.len() as u32 - EDGE
    }
    /// Returns whether an element is the same vertex as the one `period` before it.
    pub(crate) fn repeats(&self, element: u32, period: u32) -> bool {
        let before = if period == 1 {
            self.previous(element)
        } else {
            self.previous(self.previous(element))
        };
        self.value(element) == self.value(before)
    }
    /// Returns the place of an element now, counted from where the strip started; removals count
    /// once [`Self::forget`] has been called.
    pub(crate) fn place(&self, element: u32) -> u32 {
        self.ranks.rank(element) - EDGE + self.room
    }
    /// The element at a place. None if there is none.
    pub(crate) fn at(&self, place: u32) -> Option<u32> {
        let end = self.ranks.rank(self.value.len() as u32 - EDGE);
        let rank = place.checked_sub(self.room)?.checked_add(EDGE)?;
        (rank < end).then(|| self.ranks.select(rank))
    }
    /// The first element of all.
    pub(crate) fn front(&self) -> u32 {
        self.next(EDGE - 1)
    }
    /// The last element of all.
    pub(crate) fn back(&self) -> u32 {
        self.previous(self.value.len() as u32 - EDGE)
    }

    /// An element becomes another vertex; triangles that lose their area by it die.
    pub(crate) fn change(&mut self, element: u32, target: u32) {
        self.value[element as usize] = target;
    }
    /// Finds out which triangles with this element have died.
    pub(crate) fn settle(&mut self, element: u32, positions: &PositionIds) {
        let before = self.previous(element);
        for start in [self.previous(before), before, element] {
            if !self.draws(start) {
                continue;
            }
            let corners = [start, self.next(start), self.next(self.next(start))];
            if is_degenerate(corners.map(|e| positions.of_vertex[self.value(e) as usize])) {
                self.draws[start as usize] = false;
                self.drawn -= 1;
            }
        }
        while self.last_drawn > 0 && !self.draws(self.last_drawn) {
            self.last_drawn = self.previous(self.last_drawn);
        }
        while self.drawn > 0 && !self.draws(self.first_drawn) {
            self.first_drawn = self.next(self.first_drawn);
        }
    }
    /// The first element with which a drawn triangle starts. There must be one.
    pub(crate) fn first_drawn(&self) -> u32 {
        self.first_drawn
    }
    /// The last corner of the last drawn triangle. There must be one.
    pub(crate) fn last_corner(&self) -> u32 {
        self.next(self.next(self.last_drawn))
    }

    /// Takes out elements `first..=last`, which must repeat the ones before them. Their triangles,
    /// the later ones of which are drawn, belong to the elements before from now on.
    pub(crate) fn unlink_repetition(&mut self, first: u32, last: u32) {
        let before = self.previous(first);
        for (to, from) in [(self.previous(before), self.previous(last)), (before, last)] {
            let drawn = std::mem::replace(&mut self.draws[from as usize], false);
            self.draws[to as usize] = drawn;
            if self.first_drawn == from {
                self.first_drawn = to;
            }
            if self.last_drawn == from {
                self.last_drawn = to;
            }
        }
        self.unlink(first, last);
    }
    /// Takes out elements `first..=last`, none of which is a corner of a drawn triangle.
    pub(crate) fn unlink(&mut self, first: u32, last: u32) {
        let before = self.previous(first);
        let mut element = first;
        let end = self.next(last);
        while element != end {
            self.remaining[element as usize] = false;
            element = self.next(element);
        }
        self.next[before as usize] = end;
        self.previous[end as usize] = before;
    }
    /// Notes that `count` elements were removed at the front; others keep their places.
    pub(crate) fn leave_room(&mut self, count: u32) {
        self.room += count;
    }
    /// A removed element stops counting in [`Self::place`].
    pub(crate) fn forget(&mut self, element: u32) {
        self.ranks.remove(element);
    }
}
