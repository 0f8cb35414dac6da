//! Errors of readers and writers: what is wrong, where, and whose fault it is, which tells a caller
//! what to do next.

use std::fmt;

/// Whose fault it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The file could not be read.
    Unreadable,
    /// The file's content breaks the rules of its format.
    Malformed,
    /// The content is legal, but not something this version can use.
    Unsupported,
    /// The file names something outside its own folder.
    Forbidden,
    /// A limit on size, memory or time was reached.
    Limit,
    /// The output could not be written.
    NotWritten,
}

/// An error with its file and the location in it. Displays as one line: `FILE: LOCATION: PROBLEM`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FormatError {
    /// Whose fault it is.
    pub fault: Fault,
    /// The file, as the user named it (or as the file that refers to it does).
    pub file: String,
    /// Where in the file, for example `line 12` or `accessors[3]`; empty if that is not known.
    pub location: String,
    /// What is wrong and, if that is known, what to do.
    pub problem: String,
}

impl FormatError {
    /// An error that names no file yet: [`Self::in_file`] adds it.
    #[must_use]
    pub fn new(fault: Fault, location: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { fault, file: String::new(), location: location.into(), problem: problem.into() }
    }

    /// The same error, naming the file unless it already names one.
    #[must_use]
    pub fn in_file(mut self, file: &str) -> Self {
        if self.file.is_empty() {
            self.file = file.to_owned();
        }
        self
    }
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for part in [&self.file, &self.location] {
            if !part.is_empty() {
                write!(f, "{}: ", part.escape_debug())?;
            }
        }
        // The problem may quote line ends of a file.
        write!(f, "{}", self.problem.replace(['\n', '\r'], " "))
    }
}

impl std::error::Error for FormatError {}
