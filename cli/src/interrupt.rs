//! Ctrl-C, SIGTERM and SIGHUP: the process ends between two output files, never while one is being
//! renamed.

use crate::exit::{Failure, Outcome, Status};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locked while files are written; holds whether a result is in place.
static COMMITTING: Mutex<bool> = Mutex::new(false);

/// Held while files are written and renamed: an interruption waits until it is released. Its holder
/// sets it to true once a file is in place.
pub(crate) fn committing() -> MutexGuard<'static, bool> {
    COMMITTING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on SIGINT, SIGTERM and SIGHUP end the process between two writes, with status 130.
///
/// # Errors
/// If the system refuses a handler.
pub(crate) fn install() -> Outcome<()> {
    ctrlc::set_handler(|| {
        let _whole = committing();
        crate::console::error(
            &"interrupted; files already complete were kept, nothing partial was left",
        );
        std::process::exit(130);
    })
    .map_err(|e| Failure::new(Status::Bug, format!("no handler for interruptions: {e}")))
}
