//! A cursor over Masking Strips: the strips at full length, and the filtered copies that are drawn.
//!
//! A small move applies or undoes the masks of the strips that it changes. A far jump resolves the vertices that its
//! filters keep, and leaves the full strips for later.

use super::{Masking, history::Entry};
use crate::{Changes, Traffic};
use lodc_mesh::{Lod, OrientedTriangle};
use lodc_strip::strip_triangles;

/// How many entries of a strip are looked at one by one before searching among all.
const FEW: usize = 8;

/// The moving part of [`Masking`] strips.
#[derive(Clone, Debug)]
pub struct Cursor {
    lod: u32,
    /// The strips at full length, where they are not stale.
    full: Vec<u32>,
    /// The filtered copies, each where its strip is in `full`.
    drawn: Vec<u32>,
    strips: Vec<State>,
    /// What each vertex that is gone has become: made for far jumps.
    shown: Vec<u32>,
    /// All indices that are drawn.
    indices: u64,
    /// Triangles before and after, while somebody listens. Kept to save allocating.
    before: Vec<OrientedTriangle>,
    after: Vec<OrientedTriangle>,
}

/// Where a strip is.
#[derive(Clone, Copy, Debug)]
struct State {
    /// The first of its entries that is not applied. That of a strip that is not drawn stays where it was.
    next: u32,
    /// How many indices its filtered copy has; 0 if no triangle is left.
    drawn: u16,
    /// Whether the full strip is that of another LOD: a jump made the filtered copy without it.
    stale: bool,
}

impl Cursor {
    pub(super) fn new(model: &Masking) -> Self {
        let full = model.strips.indices().to_vec();
        let state = |s| State { next: model.firsts[s], drawn: model.strips.range(s).len() as u16, stale: false };
        Self {
            lod: 0,
            drawn: full.clone(),
            indices: full.len() as u64,
            full,
            strips: (0..model.strips.len()).map(state).collect(),
            shown: Vec::new(),
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
        if 2 * passed.len() < self.strips.len() {
            // A strip that several records change is brought to the end the first time.
            for &strip in &model.affected[passed] {
                rewritten += self.bring::<C, false>(model, strip as usize, to, changes);
            }
        } else {
            self.resolve(model.simplified.collapses().targets(), to);
            for strip in 0..self.strips.len() {
                rewritten += self.bring::<C, true>(model, strip, to, changes);
            }
        }
        self.lod = to;
        Traffic { records: coarse - fine, rewritten, bytes: 4 * rewritten }
    }

    /// Works out what every vertex that is gone at a LOD has become.
    fn resolve(&mut self, targets: &[u32], to: u32) {
        self.shown.resize(targets.len(), 0);
        for record in (0..to as usize).rev() {
            let target = targets[record];
            self.shown[record] = if target < to { self.shown[target as usize] } else { target };
        }
    }

    /// Brings a strip to a LOD, in a jump with the help of `shown`. Returns how many indices were drawn anew.
    fn bring<C: Changes, const JUMP: bool>(&mut self, model: &Masking, strip: usize, to: u32, changes: &mut C) -> u64 {
        let history = model.history(strip);
        let State { next, drawn, stale } = self.strips[strip];
        let Some(last) = model.entries[history.clone()].last() else { return 0 };
        let ended = last.record < to;
        let new = if ended { history.end } else { boundary(&model.entries, history.clone(), next as usize, to) };
        let filter = if new == history.start { u16::MAX } else { model.entries[new - 1].filter };
        let same = if drawn == 0 { filter == 0 } else { new == next as usize };
        if same {
            return 0;
        }
        if C::HEARD {
            let mut before = std::mem::take(&mut self.before);
            before.clear();
            self.triangles_of(model, strip, &mut before);
            self.before = before;
        }
        let range = model.strips.range(strip);
        let filter = filter & u16::MAX >> (16 - range.len());
        let mut state = State { next, drawn: filter.count_ones() as u16, stale };
        if filter != 0 {
            state = State { next: new as u32, stale: JUMP, ..state };
            let drawn = &mut self.drawn[range.clone()];
            if JUMP {
                let (input, shown) = (&model.strips.indices()[range], &self.shown);
                copy(filter, drawn, |at| if input[at] < to { shown[input[at] as usize] } else { input[at] });
            } else {
                let full = &mut self.full[range];
                move_full(model, full, strip, (!stale).then_some(next as usize), new);
                copy(filter, drawn, |at| full[at]);
            }
        }
        self.strips[strip] = state;
        self.indices = self.indices - u64::from(drawn) + u64::from(state.drawn);
        if C::HEARD {
            let mut after = std::mem::take(&mut self.after);
            after.clear();
            self.triangles_of(model, strip, &mut after);
            self.after = after;
            self.tell(changes);
        }
        u64::from(state.drawn)
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

/// Applies or undoes entries of a full strip until `new` is the first that is not applied. It was `next`; none if the
/// strip is stale.
fn move_full(model: &Masking, full: &mut [u32], strip: usize, next: Option<usize>, new: usize) {
    let (first, targets) = (model.firsts[strip] as usize, model.simplified.collapses().targets());
    let next = match next {
        Some(next) if next < new || next - new <= new - first => next,
        _ => {
            full.copy_from_slice(model.strips.strip(strip));
            first
        }
    };
    for entry in model.entries.get(next..new).unwrap_or_default() {
        let target = targets[entry.record as usize];
        each(entry.positions, |at| full[at] = target);
    }
    for entry in model.entries.get(new..next).unwrap_or_default().iter().rev() {
        each(entry.positions, |at| full[at] = entry.record);
    }
}

/// Puts what is at the positions of a mask one after the other.
fn copy(mask: u16, to: &mut [u32], from: impl Fn(usize) -> u32) {
    let mut to = to.iter_mut();
    each(mask, |at| {
        if let Some(to) = to.next() {
            *to = from(at);
        }
    });
}

/// Calls `f` with every position in a mask, the first first.
fn each(mut mask: u16, mut f: impl FnMut(usize)) {
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
