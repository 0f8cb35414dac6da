//! Buffers for every thread, used again and again.

use std::sync::Mutex;

/// One set of buffers for each thread.
pub(crate) struct ScratchPool<T>(Vec<Mutex<T>>);

impl<T> Default for ScratchPool<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Default> ScratchPool<T> {
    /// One for each thread of the present pool, or none if they are not needed.
    pub(crate) fn new(needed: bool) -> Self {
        let threads = if needed { rayon::current_num_threads() } else { 0 };
        Self((0..threads).map(|_| Mutex::default()).collect())
    }

    /// Does something with buffers that nobody else uses meanwhile.
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        match self.0.iter().find_map(|slot| slot.try_lock().ok()) {
            Some(mut scratch) => work(&mut scratch),
            // More threads than were counted: slower, no less right.
            None => work(&mut T::default()),
        }
    }
}
