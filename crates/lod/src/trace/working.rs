//! A strip while its history is traced: a doubly linked list, so that removing an element costs the
//! same anywhere, with a count of the triangles that are drawn.

use super::history::RemovalKind;
use super::ranks::Ranks;
use lodc_mesh::{NONE, PositionIds, is_degenerate};

/// Sentinels before the strip, and as many after it, so that every element has two neighbours on
/// each side. Their values differ from each other and from every vertex.
const SENTINELS: u32 = 2;

/// Consecutive elements that a record removes from a strip.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RemovedRun {
    pub(crate) first: u32,
    pub(crate) last: u32,
    pub(crate) count: u32,
    pub(crate) kind: RemovalKind,
}

/// A strip at some LOD. Elements are numbered as in the strip of LOD 0.
#[derive(Clone, Debug, Default)]
pub(crate) struct WorkingStrip {
    /// The vertex of each element, and the elements before and after it.
    value: Vec<u32>,
    previous: Vec<u32>,
    next: Vec<u32>,
    /// For each element whether it has not been removed.
    remaining: Vec<bool>,
    /// True if the triangle that starts at each element is drawn. Once it is not, it never is
    /// again.
    draws: Vec<bool>,
    drawn_count: u32,
    /// The last and the first element with which a drawn triangle starts.
    last_drawn: u32,
    first_drawn: u32,
    removed_at_front: u32,
    ranks: Ranks,
}

impl WorkingStrip {
    /// Starts with a strip of LOD 0.
    pub(crate) fn start(&mut self, strip: &[u32], positions: &PositionIds) {
        let count = strip.len() as u32 + 2 * SENTINELS;
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
        (self.drawn_count, self.first_drawn, self.last_drawn, self.removed_at_front) =
            (0, count, 0, 0);
        for (i, window) in strip.windows(3).enumerate() {
            let corners =
                [window[0], window[1], window[2]].map(|v| positions.of_vertex[v as usize]);
            if !is_degenerate(corners) {
                self.draws[i + SENTINELS as usize] = true;
                self.drawn_count += 1;
                self.first_drawn = self.first_drawn.min(i as u32 + SENTINELS);
                self.last_drawn = i as u32 + SENTINELS;
            }
        }
    }

    /// The element that was number `i` of the strip of LOD 0.
    pub(crate) fn element(i: usize) -> u32 {
        i as u32 + SENTINELS
    }
    /// The inverse of [`Self::element`].
    pub(crate) fn number(element: u32) -> usize {
        (element - SENTINELS) as usize
    }
    pub(crate) fn remains(&self, element: u32) -> bool {
        self.remaining[element as usize]
    }
    /// Returns whether any triangle is drawn.
    pub(crate) fn is_live(&self) -> bool {
        self.drawn_count > 0
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
        element >= SENTINELS && element < self.value.len() as u32 - SENTINELS
    }
    /// Returns whether an element is the same vertex as the one `period` before it.
    pub(crate) fn repeats(&self, element: u32, period: u32) -> bool {
        let previous = if period == 1 {
            self.previous(element)
        } else {
            self.previous(self.previous(element))
        };
        self.value(element) == self.value(previous)
    }
    /// Returns the offset of an element now, counted from where the strip started; removals count
    /// once [`Self::remove_rank`] has been called.
    pub(crate) fn offset(&self, element: u32) -> u32 {
        self.ranks.rank(element) - SENTINELS + self.removed_at_front
    }
    /// The element at an offset; `None` if there is none.
    pub(crate) fn element_at(&self, offset: u32) -> Option<u32> {
        let end = self.ranks.rank(self.value.len() as u32 - SENTINELS);
        let rank = offset.checked_sub(self.removed_at_front)?.checked_add(SENTINELS)?;
        (rank < end).then(|| self.ranks.select(rank))
    }
    /// The first element of all.
    pub(crate) fn front(&self) -> u32 {
        self.next(SENTINELS - 1)
    }
    /// The last element of all.
    pub(crate) fn back(&self) -> u32 {
        self.previous(self.value.len() as u32 - SENTINELS)
    }

    /// Makes an element another vertex. [`Self::update_drawn`] must follow, once all elements of a
    /// record have changed.
    pub(crate) fn set_value(&mut self, element: u32, target: u32) {
        self.value[element as usize] = target;
    }
    /// Updates which triangles with an element are drawn, after it has changed.
    pub(crate) fn update_drawn(&mut self, element: u32, positions: &PositionIds) {
        let previous = self.previous(element);
        for start in [self.previous(previous), previous, element] {
            if !self.draws(start) {
                continue;
            }
            let corners = [start, self.next(start), self.next(self.next(start))];
            if is_degenerate(corners.map(|e| positions.of_vertex[self.value(e) as usize])) {
                self.draws[start as usize] = false;
                self.drawn_count -= 1;
            }
        }
        while self.last_drawn > 0 && !self.draws(self.last_drawn) {
            self.last_drawn = self.previous(self.last_drawn);
        }
        while self.drawn_count > 0 && !self.draws(self.first_drawn) {
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

    /// Removes elements `first..=last`, which must repeat the ones before them. The triangles that
    /// start at `last` and at the element before it, which may be drawn, start at the two elements
    /// before `first` from now on.
    pub(crate) fn unlink_repetition(&mut self, first: u32, last: u32) {
        let previous = self.previous(first);
        for (to, from) in [(self.previous(previous), self.previous(last)), (previous, last)] {
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
    /// Removes elements `first..=last`, none of which is a corner of a drawn triangle.
    pub(crate) fn unlink(&mut self, first: u32, last: u32) {
        let previous = self.previous(first);
        let mut element = first;
        let end = self.next(last);
        while element != end {
            self.remaining[element as usize] = false;
            element = self.next(element);
        }
        self.next[previous as usize] = end;
        self.previous[end as usize] = previous;
    }
    /// Keeps the offsets of others after `count` elements were removed at the front.
    pub(crate) fn shift_front(&mut self, count: u32) {
        self.removed_at_front += count;
    }
    /// Lets a removed element no longer count in [`Self::offset`].
    pub(crate) fn remove_rank(&mut self, element: u32) {
        self.ranks.remove(element);
    }
}
