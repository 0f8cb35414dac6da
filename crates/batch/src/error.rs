//! Why there is nothing to do with what a run was given.

use lodc_formats::FormatError;
use std::fmt;

/// Why there is nothing to do with what a run was given, by whose fault it is: a sentence each.
#[derive(Clone, Debug, PartialEq)]
pub enum AssetError {
    /// The wishes make no sense.
    Usage(String),
    /// A folder, a list or a file cannot be read, or holds nothing of use.
    Input(String),
    /// A result has no place.
    Output(String),
    /// A file is damaged.
    Format(FormatError),
}

impl fmt::Display for AssetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(what) | Self::Input(what) | Self::Output(what) => f.write_str(what),
            Self::Format(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for AssetError {}

impl From<FormatError> for AssetError {
    fn from(error: FormatError) -> Self {
        Self::Format(error)
    }
}
