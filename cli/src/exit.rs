//! Exit statuses, and the failures that carry one: a one-line message, and whether input, options
//! or system are at fault.

use crate::jobs::JobError;
use lodc_formats::{Fault, FormatError};
use std::fmt;

/// Exit status of the process. The numbers are part of the command line's contract.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(crate) enum Status {
    /// Done.
    #[default]
    Done = 0,
    /// A check found a difference.
    Difference = 1,
    /// The command line is wrong.
    Usage = 2,
    /// The input is unreadable, malformed or unsupported.
    Input = 3,
    /// The output was not written.
    Output = 4,
    /// A limit on size, memory or time was reached.
    Limit = 5,
    /// A GPU was required and none is usable.
    NoGpu = 6,
    /// A bug of this program.
    Bug = 70,
}

impl Status {
    /// The number.
    pub(crate) fn code(self) -> u8 {
        self as u8
    }
}

/// Why a command, or its work on one input, failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Failure {
    pub(crate) status: Status,
    /// One line, without the program's name.
    pub(crate) message: String,
}

/// What to do about a bug.
pub(crate) const REPORT_IT: &str = concat!(
    "this is a bug of lodc ",
    env!("CARGO_PKG_VERSION"),
    ": please report it with the input"
);

impl Failure {
    pub(crate) fn new(status: Status, message: impl Into<String>) -> Self {
        let mut message = one_line(&message.into());
        if status == Status::Bug {
            message = format!("internal error: {message}; {REPORT_IT}");
        }
        Self { status, message }
    }
    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self::new(Status::Usage, message)
    }
}

/// The text with control characters escaped: one line, whatever file names are in it.
pub(crate) fn one_line(text: &str) -> String {
    let mut visible = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() { visible.extend(c.escape_default()) } else { visible.push(c) }
    }
    visible
}

impl From<FormatError> for Failure {
    fn from(error: FormatError) -> Self {
        let status = match error.fault {
            Fault::Unreadable | Fault::Malformed | Fault::Unsupported | Fault::Forbidden => {
                Status::Input
            }
            Fault::Limit => Status::Limit,
            Fault::NotWritten => Status::Output,
        };
        Self::new(status, error.to_string())
    }
}

impl From<lodc::Error> for Failure {
    fn from(error: lodc::Error) -> Self {
        match error {
            lodc::Error::Format(error) => error.into(),
            lodc::Error::Select(error) => error.into(),
            lodc::Error::Request(problem) => Self::usage(problem),
            lodc::Error::Bug(problem) => Self::new(Status::Bug, problem),
            other => Self::new(Status::Bug, other.to_string()),
        }
    }
}

impl From<JobError> for Failure {
    fn from(error: JobError) -> Self {
        match error {
            JobError::Usage(problem) => Self::new(Status::Usage, problem),
            JobError::Input(problem) => Self::new(Status::Input, problem),
            JobError::Output(problem) => Self::new(Status::Output, problem),
            JobError::Format(error) => error.into(),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)
    }
}

/// Result of a command or a part of it.
pub(crate) type Outcome<T> = Result<T, Failure>;
