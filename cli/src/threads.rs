//! The thread pool of a command: `--jobs`, or all processors.

use crate::exit::{Failure, Outcome, Status};
use rayon::ThreadPoolBuilder;
use std::num::NonZeroUsize;
use std::thread::available_parallelism;

/// More threads than this gain nothing; asking for more is no error.
const MOST: usize = 256;

/// Makes the process's pool of threads: as many as `--jobs` says, or one for each core. A single
/// one is that which calls: no work waits for another thread to wake.
///
/// # Errors
/// If the system has none to give.
pub(crate) fn start(jobs: Option<NonZeroUsize>) -> Outcome<()> {
    let cores = || available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let threads = jobs.unwrap_or_else(cores).get().min(MOST);
    let pool = ThreadPoolBuilder::new().num_threads(threads);
    let pool = if threads == 1 { pool.use_current_thread() } else { pool };
    let made = pool.build_global();
    made.map_err(|e| Failure::new(Status::Limit, format!("no threads to work with: {e}")))
}
