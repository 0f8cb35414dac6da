//! The thread pool of a command: `--jobs`, or all processors.

use crate::exit::{Failure, Outcome, Status};
use rayon::ThreadPoolBuilder;
use std::num::NonZeroUsize;
use std::thread::available_parallelism;

/// Threads at most; asking for more is no error. Chosen by hand: more are
/// expected to gain nothing.
const MAX_THREADS: usize = 256;

/// Makes the process's pool of threads: as many as `--jobs` says, or one for each core. With one
/// thread the calling one does the work, so that none waits for another thread to wake.
///
/// # Errors
/// If the system refuses to start them.
pub(crate) fn start(jobs: Option<NonZeroUsize>) -> Outcome<()> {
    let cores = || available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let threads = jobs.unwrap_or_else(cores).get().min(MAX_THREADS);
    let pool = ThreadPoolBuilder::new().num_threads(threads);
    let pool = if threads == 1 { pool.use_current_thread() } else { pool };
    let made = pool.build_global();
    made.map_err(|e| Failure::new(Status::Limit, format!("no threads to work with: {e}")))
}
