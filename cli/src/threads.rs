//! The threads that a command works with.

use crate::exit::{Failure, Outcome, Status};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::num::NonZeroUsize;

/// More threads than this help nobody; asking for more is no mistake.
const MOST: usize = 256;

/// As many threads as `--jobs` says, or one for each core.
///
/// # Errors
/// If the system has none to give.
pub(crate) fn pool(jobs: Option<NonZeroUsize>) -> Outcome<ThreadPool> {
    let threads = jobs.map_or(0, |n| n.get().min(MOST));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| Failure::new(Status::Limit, format!("no threads to work with: {e}")))
}
