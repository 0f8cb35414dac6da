//! Why a run cannot begin, or an asset not be worked on.

use lodc_formats::FormatError;
use std::fmt;

/// Why a run cannot begin, or an asset not be worked on. The variant says whose fault it is, the
/// text is the message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum JobError {
    /// The options contradict each other or the inputs.
    Usage(String),
    /// A folder, a list or a file cannot be read, or holds nothing of use.
    Input(String),
    /// A result cannot be written.
    Output(String),
    /// A file is damaged.
    Format(FormatError),
}

impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(what) | Self::Input(what) | Self::Output(what) => f.write_str(what),
            Self::Format(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for JobError {}

impl From<FormatError> for JobError {
    fn from(error: FormatError) -> Self {
        Self::Format(error)
    }
}
