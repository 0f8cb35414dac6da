//! The JSON documents of failures, and of commands with one result for each input.

use crate::console;
use crate::exit::{Failure, Outcome, Status};
use lodc_report::SCHEMA_VERSION;
use serde::Serialize;
use std::path::Path;

/// The document about a failure, in place of the one about a result.
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

/// The document about a result that was left alone, in place of the one about a result.
#[derive(Debug, Serialize)]
pub(crate) struct UpToDateReport {
    pub(crate) schema_version: u32,
    pub(crate) input: String,
    /// The exit status: 0.
    pub(crate) status: u8,
    pub(crate) output: String,
    /// True.
    pub(crate) up_to_date: bool,
    /// Those of the run that made the result.
    pub(crate) warnings: Vec<String>,
}

/// Result of one input: its document, or the failure in its place.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum ResultReport<R> {
    Done(R),
    UpToDate(UpToDateReport),
    Failed(FailureReport),
}

/// The document about several inputs.
#[derive(Debug, Serialize)]
struct ResultsReport<R> {
    schema_version: u32,
    /// The highest status of all results.
    status: u8,
    /// In the order of the inputs.
    results: Vec<ResultReport<R>>,
}

/// Prints a single result by itself; a list if there are, or might have been (`several`), more.
///
/// # Errors
/// If standard output cannot be written.
pub(crate) fn print<R: Serialize>(
    several: bool,
    worst: Status,
    mut results: Vec<ResultReport<R>>,
) -> Outcome<()> {
    match results.pop() {
        Some(only) if !several && results.is_empty() => console::json(&only),
        last => {
            results.extend(last);
            let (schema_version, status) = (SCHEMA_VERSION, worst.code());
            console::json(&ResultsReport { schema_version, status, results })
        }
    }
}

/// Prints a document about a failure if JSON was asked for, and passes the outcome on.
///
/// # Errors
/// That of the outcome, or if standard output cannot be written.
pub(crate) fn print_failure<T>(json: bool, outcome: Outcome<T>) -> Outcome<T> {
    if let (true, Err(failure)) = (json, &outcome) {
        console::json(&FailureReport::new(failure))?;
    }
    outcome
}
