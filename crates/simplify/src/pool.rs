//! Ranking many groups at once, for metrics whose prices take long: buffers for every thread, and
//! the loop over them.

use crate::engine::{Choice, Engine, Scratch, Serial};
use crate::heap::Heap;
use crate::metric::Metric;
use crate::working::RESTRICTED;
use rayon::prelude::*;
use std::sync::Mutex;

/// Buffers for every thread, used again and again.
pub(crate) struct Pool<E>(Vec<Mutex<Scratch<E>>>);

impl<E> Default for Pool<E> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<E: Default> Pool<E> {
    /// One for each thread of the present pool.
    pub(crate) fn new() -> Self {
        Self((0..rayon::current_num_threads()).map(|_| Mutex::default()).collect())
    }

    /// Does something with buffers that nobody else uses meanwhile.
    fn with<T>(&self, work: impl FnOnce(&mut Scratch<E>) -> T) -> T {
        match self.0.iter().find_map(|slot| slot.try_lock().ok()) {
            Some(mut scratch) => work(&mut scratch),
            // More threads than were counted: slower, no less right.
            None => work(&mut Scratch::default()),
        }
    }
}

impl<M: Metric> Engine<'_, M> {
    /// Ranks again what a commit changed, all groups at once. What changed elsewhere, by having
    /// been hidden or uncovered, is noticed when its turn comes.
    pub(crate) fn look_again(
        &mut self,
        best: &mut [Choice],
        heap: &mut Heap,
        serial: &mut Serial<M::ViewScratch>,
    ) {
        let stale = std::mem::take(&mut serial.stale);
        let mut due: Vec<u32> = stale.iter().copied().filter(|&g| self.is_due(g)).collect();
        if self.restricted > 0 {
            for &g in &stale {
                self.mesh.each_neighbour(g, |other| {
                    if self.mesh.has(other, RESTRICTED) && serial.first_time(other) {
                        due.push(other);
                    }
                });
            }
        }
        serial.stale = stale;
        for &g in &due {
            self.set_restricted(g, false);
        }
        let this = &*self;
        let rank = |&g: &u32| serial.pool.with(|scratch| this.rank(g, scratch));
        let choices: Vec<Choice> = due.par_iter().with_max_len(1).map(rank).collect();
        for (g, choice) in due.into_iter().zip(choices) {
            best[g as usize] = choice;
            if choice.cost.is_nan() { heap.remove(g) } else { heap.set(g, choice.cost) }
        }
    }
}
