//! The JSON documents of failures, and of commands with a result for each of several inputs.

use crate::console;
use crate::exit::{Failure, Outcome, Status};
use crate::report::{ExtractReport, SCHEMA_VERSION};
use serde::Serialize;
use std::path::Path;

/// A document about what failed, in the place of the one about what was done.
#[derive(Debug, Serialize)]
pub(crate) struct FailureReport {
    pub(crate) schema_version: u32,
    /// The input that failed; null if the command did not get that far.
    pub(crate) input: Option<String>,
    /// The exit status.
    pub(crate) status: u8,
    pub(crate) error: String,
}

impl FailureReport {
    /// A failure of the whole command.
    pub(crate) fn new(failure: &Failure) -> Self {
        let (status, error) = (failure.status.code(), failure.message.clone());
        Self { schema_version: SCHEMA_VERSION, input: None, status, error }
    }
    /// A failure of one input.
    pub(crate) fn of(input: &Path, failure: &Failure) -> Self {
        Self { input: Some(input.display().to_string()), ..Self::new(failure) }
    }
}

/// Result of one of several inputs.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum ResultReport {
    Done(ExtractReport),
    Failed(FailureReport),
}

/// `extract --json` of several inputs.
#[derive(Debug, Serialize)]
pub(crate) struct ResultsReport {
    pub(crate) schema_version: u32,
    /// The highest of all.
    pub(crate) status: u8,
    /// In the order of the inputs.
    pub(crate) results: Vec<ResultReport>,
}

impl ResultsReport {
    pub(crate) fn new(worst: Status, results: Vec<ResultReport>) -> Self {
        Self { schema_version: SCHEMA_VERSION, status: worst.code(), results }
    }
}

/// Prints a document about a failure if JSON was asked for, and passes the outcome on.
///
/// # Errors
/// That of the outcome, or if standard output cannot be written.
pub(crate) fn reported<T>(json: bool, outcome: Outcome<T>) -> Outcome<T> {
    if let (true, Err(failure)) = (json, &outcome) {
        console::json(&FailureReport::new(failure))?;
    }
    outcome
}
