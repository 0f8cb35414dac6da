//! A queue of assets: several at a time, the largest first, within one budget of memory.

use std::path::Path;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Bytes of memory that a byte of an input file may come to. Text has some 70 bytes for each
/// triangle, a GLB some 30; images only make this more.
const MEMORY_OF_BYTE: u64 = 14;

/// Bytes of memory that an asset may need where nothing but the size of its file and, for glTF, of
/// its buffers is known; 0 if there is none.
#[must_use]
pub fn expected_bytes(input: &Path) -> u64 {
    let size = |path: &Path| path.metadata().map_or(0, |m| m.len());
    let mut bytes = size(input);
    if input.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf")) {
        bytes += size(&input.with_extension("bin"));
    }
    bytes.saturating_mul(MEMORY_OF_BYTE)
}

/// Limits on work at one time.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Assets at one time.
    pub workers: usize,
    /// Bytes of memory, all assets together; an asset that is expected to need more runs alone.
    pub bytes: u64,
}

/// Assets at work and assets taken from the queue.
#[derive(Debug, Default)]
struct State {
    next: usize,
    running: usize,
    bytes: u64,
}

/// Does `work` for each of `needs.len()` assets. `needs` are the bytes that each is expected to
/// take. The results are in the order of `needs`, whatever the order of work.
pub fn run<R: Send>(needs: &[u64], budget: Budget, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let mut order: Vec<usize> = (0..needs.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(needs[i]), i));
    let (state, freed) = (Mutex::new(State::default()), Condvar::new());
    let results: Vec<Mutex<Option<R>>> = needs.iter().map(|_| Mutex::new(None)).collect();
    let worker = || {
        while let Some(asset) = take(&order, needs, budget, &state, &freed) {
            let result = work(asset);
            *locked(&results[asset]) = Some(result);
            let mut now = locked(&state);
            now.running -= 1;
            now.bytes -= needs[asset];
            freed.notify_all();
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..budget.workers.clamp(1, needs.len().max(1)) {
            scope.spawn(worker);
        }
        worker();
    });
    let all = results.into_iter().map(|r| r.into_inner().unwrap_or_else(PoisonError::into_inner));
    all.map(|result| result.expect("every asset has had its turn")).collect()
}

/// The next asset, as soon as there is room for it; none when all are taken.
fn take(
    order: &[usize],
    needs: &[u64],
    budget: Budget,
    state: &Mutex<State>,
    freed: &Condvar,
) -> Option<usize> {
    let mut now = locked(state);
    loop {
        let &asset = order.get(now.next)?;
        if now.running == 0 || now.bytes.saturating_add(needs[asset]) <= budget.bytes {
            now.next += 1;
            now.running += 1;
            now.bytes += needs[asset];
            return Some(asset);
        }
        now = freed.wait(now).unwrap_or_else(PoisonError::into_inner);
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn results_are_in_order_and_memory_stays_within_the_budget() {
        let needs: Vec<u64> = (0..40).map(|i| i * 7 % 13 + 1).collect();
        let budget = Budget { workers: 5, bytes: 20 };
        let (used, most) = (AtomicU64::new(0), AtomicU64::new(0));
        let results = run(&needs, budget, |i| {
            let now = used.fetch_add(needs[i], Ordering::SeqCst) + needs[i];
            most.fetch_max(now, Ordering::SeqCst);
            std::thread::yield_now();
            used.fetch_sub(needs[i], Ordering::SeqCst);
            i
        });
        assert_eq!(results, (0..40).collect::<Vec<_>>());
        assert!(most.load(Ordering::SeqCst) <= budget.bytes);
    }

    #[test]
    fn only_files_are_expected_to_need_memory() {
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        assert!(expected_bytes(&package.join("Cargo.toml")) > MEMORY_OF_BYTE);
        assert_eq!(expected_bytes(Path::new("-")), 0);
        assert_eq!(expected_bytes(&package.join("no such file.obj")), 0);
    }

    #[test]
    fn the_largest_is_first_and_one_beyond_the_budget_still_runs() {
        let order = Mutex::new(vec![]);
        let budget = Budget { workers: 1, bytes: 3 };
        run(&[1, 100, 2], budget, |i| locked(&order).push(i));
        assert_eq!(*locked(&order), [1, 2, 0]);
        assert!(run(&[], budget, |i| i).is_empty());
    }
}
