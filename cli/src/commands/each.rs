//! Work on one of several inputs: its failures are its own, and the others have their turn.

use crate::console;
use crate::exit::{Failure, Outcome, Status};
use crate::output;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// The message of a panic. The panic hook has said what and where.
const PANIC: &str = "internal error";

/// Does the work on one input. A panic is a failure of this input alone, and a failure names it.
///
/// # Errors
/// If the work fails.
pub(crate) fn guarded<T>(input: &Path, work: impl FnOnce() -> Outcome<T>) -> Outcome<T> {
    let done = catch_unwind(AssertUnwindSafe(work));
    done.unwrap_or_else(|_| Err(Failure::new(Status::Bug, PANIC))).map_err(|f| naming(input, f))
}

/// An error in a file that the input refers to names that file; with several inputs both are
/// needed.
fn naming(input: &Path, failure: Failure) -> Failure {
    let name = input.display().to_string();
    let of_input = matches!(failure.status, Status::Input | Status::Usage);
    if !of_input || failure.message.contains(&name) || output::is_stream(input) {
        return failure;
    }
    Failure::new(failure.status, format!("{name}: {}", failure.message))
}

/// Prints a failure, unless it is a panic, which has been reported.
pub(crate) fn print(failure: &Failure) {
    if failure.message != PANIC {
        console::error(failure);
    }
}
