//! The only place that prints: results on standard output, messages on standard error.

use crate::exit::{Failure, Outcome, Status, one_line};
use crate::warnings::merged;
use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Verbosity of messages on standard error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Loudness {
    /// Errors only (`-q`).
    Quiet,
    /// Errors, warnings, summaries and, on a terminal, progress.
    Normal,
    /// Seconds and peak memory per stage too (`-v`).
    Verbose,
}

/// Calls the function that it is given, which prints, with the progress bar off the terminal.
pub(crate) type PrintHook = Box<dyn Fn(&dyn Fn()) + Send>;

struct Console {
    loudness: Loudness,
    print_hook: Option<PrintHook>,
    /// Whether writing to standard output has begun.
    printed: bool,
}

// A global because warnings arise everywhere and there is one standard error.
static CONSOLE: Mutex<Console> =
    Mutex::new(Console { loudness: Loudness::Normal, print_hook: None, printed: false });

fn console() -> MutexGuard<'static, Console> {
    CONSOLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes every message print inside the hook, from now on; without one, directly.
pub(crate) fn set_print_hook(print_hook: Option<PrintHook>) {
    console().print_hook = print_hook;
}

/// Chooses how much is said.
pub(crate) fn set_loudness(loudness: Loudness) {
    console().loudness = loudness;
}

/// Returns whether messages of this loudness are wanted.
pub(crate) fn wants(loudness: Loudness) -> bool {
    console().loudness >= loudness
}

/// Returns whether anything has been written to standard output, or writing has begun.
pub(crate) fn has_printed() -> bool {
    console().printed
}

/// Prints an error. A failure to print it is ignored: there is no other way to report it.
pub(crate) fn error(what: &impl Display) {
    line(&format!("lodc: {what}"));
}

/// Prints a warning about something that did not stop the work.
pub(crate) fn warning(file: &str, what: &str) {
    if wants(Loudness::Normal) {
        line(&format!("lodc: {}: warning: {}", one_line(file), one_line(what)));
    }
}

/// Prints the warnings about a file: all of them with `-v`, or else one line for each kind.
pub(crate) fn warnings(file: &str, all: &[String]) {
    let lines = if wants(Loudness::Verbose) { all.to_vec() } else { merged(all) };
    lines.iter().for_each(|what| warning(file, what));
}

/// Prints text that helps but is not a result.
pub(crate) fn note(text: &str) {
    if wants(Loudness::Normal) {
        line(text);
    }
}

/// Prints a line for the CI system that runs the program, also with `-q`.
pub(crate) fn annotation(text: &str) {
    line(text);
}

/// Prints text that only `-v` asks for.
pub(crate) fn detail(text: &str) {
    if wants(Loudness::Verbose) {
        line(text);
    }
}

fn line(text: &str) {
    // Whole lines in one call, so that lines of several threads do not mix.
    let print = || drop(io::stderr().lock().write_all(format!("{text}\n").as_bytes()));
    match &console().print_hook {
        Some(hook) => hook(&print),
        None => print(),
    }
}

/// Prints a result for people. A closed pipe is no failure: its reader needed no more.
///
/// # Errors
/// If standard output cannot be written for another reason.
pub(crate) fn result(text: &str) -> Outcome<()> {
    match print(format!("{text}\n").as_bytes()) {
        Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(|e| stdout_failure(&e)),
    }
}

/// Prints one JSON document.
///
/// # Errors
/// If standard output cannot be written.
pub(crate) fn json(document: &impl serde::Serialize) -> Outcome<()> {
    let text = serde_json::to_string_pretty(document)
        .expect("report structs have string keys and finite numbers");
    result(&text)
}

/// Prints one JSON document in one line, at once.
///
/// # Errors
/// If standard output cannot be written.
pub(crate) fn json_line(document: &impl serde::Serialize) -> Outcome<()> {
    let text = serde_json::to_string(document)
        .expect("report structs have string keys and finite numbers");
    result(&text)
}

/// Writes an output file's bytes to standard output. Here a closed pipe is a failure: the reader
/// got half a file.
///
/// # Errors
/// If not all bytes could be written.
pub(crate) fn bytes(bytes: &[u8]) -> Outcome<()> {
    print(bytes).map_err(|e| stdout_failure(&e))
}

fn print(bytes: &[u8]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    console().printed = true;
    out.write_all(bytes)?;
    out.flush()
}

fn stdout_failure(e: &io::Error) -> Failure {
    Failure::new(Status::Output, format!("standard output: {e}"))
}
