//! What a collapse changes around it: who is ranked again, at once or later.

use super::{Engine, LoopState, Queue};
use crate::choice::Choice;
use crate::choose::heap::Heap;
use crate::choose::{SelectionBuffers, Selector};
use crate::cut::mesh::{DEAD, HUB_VALENCE, LOCKED, RESTRICTED, STALE};
use crate::cut::region::Region;
use crate::metric::Reprice;
use rayon::prelude::*;

/// Restricted groups next to a group with more faces than this wait until the queue is empty.
const MAX_WALKED: usize = 32;
/// After this many of them in one collapse the others wait too: where all is tangled, they would be
/// ranked again and again.
const MAX_RESTRICTED: usize = 16;
/// The most collapses after which groups wait to be priced anew by a metric, so that all threads
/// have work at once, and the faces that there are for each.
const MAX_WAITING: usize = 32;
const FACES_PER_WAITING: usize = 512;

impl<M: Reprice> Engine<'_, M> {
    /// Ranks again what a commit onto `to` may have changed.
    pub(super) fn refresh(&mut self, to: u32, queue: Queue, limit: f32, heap: &mut Heap) {
        let mut due = std::mem::take(&mut self.state.due);
        let before = due.len();
        due.extend(self.state.touched.groups.iter().copied().filter(|&g| self.is_due(g)));
        let changed = due.len();
        if matches!(queue, Queue::All) && self.state.restricted > 0 {
            self.add_restricted(&mut due, before);
        }
        if self.metric.is_active() {
            self.state.due = due;
            self.wait(before, heap);
            return;
        }
        for &g in &due[..changed] {
            self.rerank(g);
            self.requeue(g, limit, heap);
        }
        due[changed..].iter().for_each(|&g| self.region.prefetch(g));
        for &g in &due[changed..] {
            if !self.is_still_best(g) {
                self.search_again(g);
                self.requeue(g, limit, heap);
            }
        }
        due.clear();
        self.state.due = due;
        self.note_risen_costs(to);
        if let Some(first) = heap.first() {
            self.region.prefetch(first);
        }
    }

    /// Flags the groups due since the last collapse as stale, and ranks all that wait if they are
    /// many.
    fn wait(&mut self, before: usize, heap: &mut Heap) {
        let Self { region, state, .. } = self;
        let mut kept = before;
        for i in before..state.due.len() {
            let g = state.due[i];
            if !region.mesh.has(g, STALE) {
                region.mesh.add_flags(g, STALE);
                state.due[kept] = g;
                kept += 1;
            }
        }
        state.due.truncate(kept);
        state.waiting += 1;
        let most = region.mesh.live_faces as usize / FACES_PER_WAITING;
        if state.waiting >= most.clamp(1, MAX_WAITING) {
            self.rerank_waiting(heap);
        }
    }

    /// Adds the restricted groups next to those that are due.
    fn add_restricted(&mut self, due: &mut Vec<u32>, before: usize) {
        let Self { region, state, .. } = self;
        let touched = due.len();
        for i in before..touched {
            if region.mesh.valence(due[i]) > MAX_WALKED {
                continue;
            }
            if due.len() - touched > MAX_RESTRICTED {
                break;
            }
            region.mesh.each_neighbour(due[i], |other| {
                if region.mesh.has(other, RESTRICTED) && state.touched.mark(other) {
                    due.push(other);
                }
            });
        }
    }

    /// Flags the groups bound for `to`. Around it nothing moved but its own history, and that only
    /// grew: their costs are lower bounds from now on.
    fn note_risen_costs(&mut self, to: u32) {
        if !self.is_due(to) {
            return;
        }
        let Region { mesh, choices, .. } = &mut *self.region;
        let LoopState { touched, due, .. } = &mut self.state;
        let is_bound =
            |g: u32| choices.get(g as usize).is_some_and(|c| c.to == to) && !touched.is_marked(g);
        mesh.each_neighbour(to, |g| due.extend(is_bound(g).then_some(g)));
        for g in due.drain(..) {
            mesh.add_flags(g, STALE);
        }
    }

    /// Ranks the groups that wait for it, all at once. What changed elsewhere, hidden or uncovered
    /// by now, is noticed when its turn comes.
    pub(super) fn rerank_waiting(&mut self, heap: &mut Heap) {
        let mut due = std::mem::take(&mut self.state.due);
        due.retain(|&g| !self.region.mesh.has(g, DEAD));
        for &g in &due {
            self.set_restricted(g, false);
        }
        let (Selector { pricer, .. }, state) = self.parts();
        let pool = &state.pool;
        let rank = |&g: &u32| pool.with(|scratch| pricer.rank(g, scratch));
        let choices: Vec<Choice> = due.par_iter().with_max_len(4).map(rank).collect();
        for (&g, choice) in due.iter().zip(choices) {
            self.region.choices[g as usize] = choice;
            self.region.mesh.clear_flags(g, STALE);
            self.requeue(g, f32::INFINITY, heap);
        }
        due.clear();
        (self.state.due, self.state.waiting) = (due, 0);
    }

    /// Puts a group where it belongs in the queue.
    #[inline]
    fn requeue(&mut self, g: u32, limit: f32, heap: &mut Heap) {
        let cost = self.region.choices[g as usize].cost;
        if cost <= limit && !self.region.mesh.has(g, LOCKED) {
            heap.set(g, cost);
        } else {
            heap.remove(g);
        }
    }

    /// Returns whether a group is to be ranked again after a neighbour moved. Hubs with hundreds of
    /// neighbours are ranked after some of them moved, else a fan would take quadratic time;
    /// legality is always checked anew.
    fn is_due(&self, group: u32) -> bool {
        let faces = self.region.mesh.valence(group);
        faces < HUB_VALENCE || faces % (faces / 16).next_power_of_two() < 2
    }

    pub(super) fn rerank(&mut self, g: u32) {
        self.set_restricted(g, false);
        self.region.mesh.clear_flags(g, STALE);
        let (Selector { pricer, .. }, state) = self.parts();
        let SelectionBuffers { scratch, lists, .. } = &mut state.selection;
        let choice = if let Some(choice) = pricer.rank_plain(g) {
            lists.forget(g);
            choice
        } else {
            let choice = pricer.rank_any(g, scratch);
            lists.keep(g, &scratch.priced);
            choice
        };
        self.region.choices[g as usize] = choice;
    }

    /// Returns whether nothing that the last commit touched changes the choice of a restricted
    /// group, whose own faces are as they were.
    fn is_still_best(&mut self, g: u32) -> bool {
        let (selector, LoopState { selection, touched, .. }) = self.parts();
        selector.is_still_best(g, touched, selection)
    }

    /// Looks for the cheapest legal collapse of a restricted group, whose own faces are as they
    /// were.
    fn search_again(&mut self, g: u32) {
        let (selector, state) = self.parts();
        let found = selector.search(g, &mut state.selection);
        let restricted = state.selection.refused;
        self.set_restricted(g, restricted);
        self.region.mesh.clear_flags(g, STALE);
        self.region.choices[g as usize] = found.map_or(Choice::NONE, |legal| legal.choice);
    }

    /// Notes whether some of a group's collapses were refused, and how many such groups there are.
    pub(super) fn set_restricted(&mut self, group: u32, restricted: bool) {
        if self.region.mesh.has(group, RESTRICTED) != restricted {
            self.region.mesh.flags[group as usize] ^= RESTRICTED;
            let count = &mut self.state.restricted;
            *count = if restricted { *count + 1 } else { count.saturating_sub(1) };
        }
    }
}
