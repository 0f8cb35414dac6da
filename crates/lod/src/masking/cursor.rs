//! A cursor over Masking Strips: the strips at full length, and the filtered copies that are drawn.

use super::{Masking, history::Entry};
use crate::{Changes, Traffic};
use lodc_mesh::{Lod, OrientedTriangle};
use lodc_strip::strip_triangles;

/// How many entries of a strip are gone through one by one before it is quicker to start from its vertices at LOD 0.
const FEW: usize = 8;

/// The moving part of [`Masking`] strips.
#[derive(Clone, Debug)]
pub struct Cursor {
    lod: u32,
    /// The strips at full length. Out of date for strips that are not drawn.
    full: Vec<u32>,
    /// The filtered copies, each where its strip is in `full`.
    drawn: Vec<u32>,
    strips: Vec<State>,
    /// All indices that are drawn.
    indices: u64,
    /// Triangles before and after, while somebody listens. Kept to save allocating.
    before: Vec<OrientedTriangle>,
    after: Vec<OrientedTriangle>,
}

/// Where a strip is.
#[derive(Clone, Copy, Debug)]
struct State {
    /// The first of its entries that is not applied to the full strip.
    next: u32,
    /// How many indices its filtered copy has.
    drawn: u32,
}

impl Cursor {
    pub(super) fn new(model: &Masking) -> Self {
        let full = model.strips.indices().to_vec();
        let state = |s| State { next: model.firsts[s], drawn: model.strips.range(s).len() as u32 };
        Self {
            lod: 0,
            drawn: full.clone(),
            indices: full.len() as u64,
            full,
            strips: (0..model.strips.len()).map(state).collect(),
            before: Vec::new(),
            after: Vec::new(),
        }
    }

    pub(super) fn lod(&self) -> Lod {
        Lod(self.lod)
    }

    pub(super) fn drawn(&self) -> u64 {
        self.indices
    }

    /// What is drawn of a strip, as a graphics card gets it: empty if none of its triangles is left.
    ///
    /// # Panics
    /// If there is no such strip.
    #[must_use]
    pub fn strip(&self, model: &Masking, strip: usize) -> &[u32] {
        &self.drawn[model.strips.range(strip)][..self.strips[strip].drawn as usize]
    }

    pub(super) fn triangles(&self, model: &Masking) -> Vec<OrientedTriangle> {
        let mut triangles = Vec::with_capacity(model.simplified.collapses().triangles_at(self.lod()) as usize);
        for strip in 0..self.strips.len() {
            self.triangles_of(model, strip, &mut triangles);
        }
        triangles
    }

    /// Appends the triangles that a strip draws.
    fn triangles_of(&self, model: &Masking, strip: usize, triangles: &mut Vec<OrientedTriangle>) {
        let place = |v: u32| model.positions.of_vertex[v as usize];
        for t in strip_triangles(self.strip(model, strip)) {
            let [a, b, c] = t.map(place);
            if a != b && b != c && c != a {
                triangles.push(OrientedTriangle::new(model.submeshes[strip], t));
            }
        }
    }

    pub(super) fn seek<C: Changes>(&mut self, model: &Masking, lod: Lod, changes: &mut C) -> Traffic {
        let (from, to) = (self.lod, model.simplified.collapses().floor(lod).0);
        let (fine, coarse) = (from.min(to), from.max(to));
        let mut rewritten = 0;
        let passed = model.starts[fine as usize] as usize..model.starts[coarse as usize] as usize;
        if passed.len() < self.strips.len() {
            // A strip that several records change is brought to the end the first time.
            for &strip in &model.affected[passed] {
                rewritten += self.bring(model, strip as usize, to, changes);
            }
        } else {
            for strip in 0..self.strips.len() {
                rewritten += self.bring(model, strip, to, changes);
            }
        }
        self.lod = to;
        Traffic { records: coarse - fine, rewritten, bytes: 4 * rewritten }
    }

    /// Brings a strip to a LOD, and tells which triangles that changes. Returns how many indices were drawn anew.
    fn bring<C: Changes>(&mut self, model: &Masking, strip: usize, to: u32, changes: &mut C) -> u64 {
        let history = model.history(strip);
        let State { next, drawn } = self.strips[strip];
        let (next, entries) = (next as usize, &model.entries);
        let Some(last) = entries[history.clone()].last() else { return 0 };
        let new = if last.record < to { history.end } else { boundary(entries, history.clone(), next, to) };
        let filter = match new {
            n if n == history.start => u64::MAX,
            n => entries[n - 1].filter,
        };
        if (drawn != 0 && new == next) || (drawn == 0 && filter == 0) {
            return 0;
        }
        if C::HEARD {
            self.before.clear();
            let mut before = std::mem::take(&mut self.before);
            self.triangles_of(model, strip, &mut before);
            self.before = before;
        }
        // A strip that is not drawn stays as it is until it is drawn again.
        let drawn_now = if filter == 0 {
            0
        } else {
            self.move_full(model, strip, new, to);
            self.strips[strip].next = new as u32;
            self.copy(model, strip, filter)
        };
        self.indices = self.indices - u64::from(drawn) + u64::from(drawn_now);
        self.strips[strip].drawn = drawn_now;
        if C::HEARD {
            self.after.clear();
            let mut after = std::mem::take(&mut self.after);
            self.triangles_of(model, strip, &mut after);
            self.after = after;
            self.tell(changes);
        }
        u64::from(drawn_now)
    }

    /// Applies or undoes entries of a full strip until `new` is the first that is not applied.
    fn move_full(&mut self, model: &Masking, strip: usize, new: usize, to: u32) {
        let (range, first) = (model.strips.range(strip), model.firsts[strip] as usize);
        let (next, targets) = (self.strips[strip].next as usize, model.simplified.collapses().targets());
        let full = &mut self.full[range.clone()];
        if next.abs_diff(new) > FEW {
            if new < next {
                full.copy_from_slice(&model.strips.indices()[range]);
            }
            for v in full {
                while *v < to {
                    *v = targets[*v as usize];
                }
            }
        } else if new > next {
            for entry in &model.entries[next..new] {
                let target = targets[entry.record as usize];
                each(entry.positions, |at| full[at] = target);
            }
        } else {
            for entry in model.entries[new..next].iter().rev() {
                each(entry.positions, |at| full[at] = entry.record);
            }
        }
        debug_assert!(first <= new);
    }

    /// Makes the filtered copy of a strip. Returns its length.
    fn copy(&mut self, model: &Masking, strip: usize, filter: u64) -> u32 {
        let range = model.strips.range(strip);
        let (full, drawn) = (&self.full[range.clone()], &mut self.drawn[range]);
        if filter == u64::MAX {
            drawn.copy_from_slice(full);
            return full.len() as u32;
        }
        let mut count = 0;
        each(filter, |at| {
            drawn[count] = full[at];
            count += 1;
        });
        count as u32
    }

    /// Tells what is in one of the two lists and not in the other, each as often.
    fn tell(&mut self, changes: &mut impl Changes) {
        self.before.sort_unstable();
        self.after.sort_unstable();
        let (mut before, mut after) = (self.before.iter().peekable(), self.after.iter().peekable());
        while let (Some(&&b), Some(&&a)) = (before.peek(), after.peek()) {
            if b <= a {
                before.next();
            }
            if a <= b {
                after.next();
            }
            match b.cmp(&a) {
                std::cmp::Ordering::Less => changes.gone(b),
                std::cmp::Ordering::Greater => changes.came(a),
                std::cmp::Ordering::Equal => {}
            }
        }
        before.for_each(|&t| changes.gone(t));
        after.for_each(|&t| changes.came(t));
    }
}

/// Calls `f` with every position in a mask, the first first.
fn each(mut mask: u64, mut f: impl FnMut(usize)) {
    while mask != 0 {
        f(mask.trailing_zeros() as usize);
        mask &= mask - 1;
    }
}

/// The first entry of a strip that is not before `to`, looked for around `near`.
fn boundary(entries: &[Entry], history: std::ops::Range<usize>, near: usize, to: u32) -> usize {
    let (mut low, mut high) = (history.start, history.end);
    let mut at = near;
    for _ in 0..FEW {
        if at < high && entries[at].record < to {
            at += 1;
            low = at;
        } else if at > low && entries[at - 1].record >= to {
            at -= 1;
            high = at;
        } else {
            return at;
        }
    }
    low + entries[low..high].partition_point(|entry| entry.record < to)
}
