//! A queue of assets for several workers: the largest first, within one budget of memory.

use std::path::Path;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Bytes of memory that each byte of an input file is expected to take. Text has about 70 bytes for
/// each triangle, a GLB about 30, so this is 400 to 1,000 bytes for each triangle; images in a file
/// make the estimate too large. Chosen by hand: too small, and assets together run out of memory;
/// too large, and fewer run at one time.
const MEMORY_PER_INPUT_BYTE: u64 = 14;

/// Bytes of memory that an asset is expected to need, from nothing but the size of its file and,
/// for `x.gltf`, of `x.bin`; 0 if there is no such file.
#[must_use]
pub(crate) fn expected_bytes(input: &Path) -> u64 {
    let size = |path: &Path| path.metadata().map_or(0, |m| m.len());
    let mut bytes = size(input);
    if input.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf")) {
        bytes += size(&input.with_extension("bin"));
    }
    bytes.saturating_mul(MEMORY_PER_INPUT_BYTE)
}

/// Limits on the work that is done at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    /// Assets.
    pub(crate) workers: usize,
    /// Bytes of memory, all assets together; an asset that is expected to need more runs alone.
    pub(crate) bytes: u64,
}

/// Assets that wait for a worker, those that need most memory first.
pub(crate) struct Queue<'a> {
    /// Numbers of assets in the order in which they are taken.
    order: Vec<usize>,
    needs: &'a [u64],
    /// Bytes of memory that all assets at work may need together.
    budget_bytes: u64,
    progress: Mutex<Progress>,
    /// Notified when an asset is done and its memory is free.
    memory_freed: Condvar,
}

#[derive(Default)]
struct Progress {
    /// Assets taken so far.
    taken: usize,
    /// Assets that workers have now.
    running: usize,
    /// What those are expected to need.
    reserved_bytes: u64,
}

impl<'a> Queue<'a> {
    /// A queue of `needs.len()` assets. `needs` are the bytes of memory that each is expected to
    /// take; one that needs more than `budget_bytes` is worked on alone.
    pub(crate) fn new(needs: &'a [u64], budget_bytes: u64) -> Self {
        let mut order: Vec<usize> = (0..needs.len()).collect();
        order.sort_by_key(|&asset| (std::cmp::Reverse(needs[asset]), asset));
        let (progress, memory_freed) = (Mutex::new(Progress::default()), Condvar::new());
        Self { order, needs, budget_bytes, progress, memory_freed }
    }

    /// Waits until there is memory for the next asset and takes it; none when all are taken.
    pub(crate) fn take(&self) -> Option<usize> {
        let mut now = locked(&self.progress);
        loop {
            let &asset = self.order.get(now.taken)?;
            let bytes = now.reserved_bytes.saturating_add(self.needs[asset]);
            if now.running == 0 || bytes <= self.budget_bytes {
                now.taken += 1;
                now.running += 1;
                now.reserved_bytes += self.needs[asset];
                return Some(asset);
            }
            now = self.memory_freed.wait(now).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Gives back the memory of an asset that is done.
    pub(crate) fn release(&self, asset: usize) {
        let mut now = locked(&self.progress);
        now.running -= 1;
        now.reserved_bytes -= self.needs[asset];
        self.memory_freed.notify_all();
    }
}

/// What a mutex protects, even if a worker has panicked.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn each_asset_is_taken_once_and_memory_stays_within_the_budget() {
        let needs: Vec<u64> = (0..40).map(|i| i * 7 % 13 + 1).collect();
        let queue = Queue::new(&needs, 20);
        let (used, peak) = (AtomicU64::new(0), AtomicU64::new(0));
        let taken = Mutex::new(vec![]);
        let worker = || {
            while let Some(asset) = queue.take() {
                let now = used.fetch_add(needs[asset], Ordering::SeqCst) + needs[asset];
                peak.fetch_max(now, Ordering::SeqCst);
                std::thread::yield_now();
                used.fetch_sub(needs[asset], Ordering::SeqCst);
                locked(&taken).push(asset);
                queue.release(asset);
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..5 {
                scope.spawn(worker);
            }
        });
        let mut taken = locked(&taken);
        taken.sort_unstable();
        assert_eq!(*taken, (0..40).collect::<Vec<_>>());
        assert!(peak.load(Ordering::SeqCst) <= 20);
    }

    #[test]
    fn only_files_are_expected_to_need_memory() {
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert!(expected_bytes(&package.join("Cargo.toml")) > MEMORY_PER_INPUT_BYTE);
        assert_eq!(expected_bytes(Path::new("-")), 0);
        assert_eq!(expected_bytes(&package.join("no such file.obj")), 0);
    }

    #[test]
    fn the_largest_is_first_and_one_beyond_the_budget_still_has_its_turn() {
        let taken = |needs: &[u64]| -> Vec<usize> {
            let queue = Queue::new(needs, 3);
            std::iter::from_fn(|| queue.take().inspect(|&asset| queue.release(asset))).collect()
        };
        assert_eq!(taken(&[1, 100, 2]), [1, 2, 0]);
        assert!(taken(&[]).is_empty());
    }
}
