//! Errors of the crate's public functions, sorted by whose fault they are.

use lodc_formats::FormatError;
use lodc_select::SelectError;
use std::fmt;

/// Why something failed. Displays as one line.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// A file is unreadable, malformed, unsupported or too large, or was not written.
    Format(FormatError),
    /// A level that the scene does not have was asked for.
    Select(SelectError),
    /// A graphics device is missing, too small or failed.
    #[cfg(feature = "gpu")]
    Device(lodc_gpu::GpuError),
    /// What was asked for does not fit the file.
    Request(String),
    /// A bug of this library.
    Bug(String),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Format(error) => error.fmt(f),
            Self::Select(error) => error.fmt(f),
            #[cfg(feature = "gpu")]
            Self::Device(error) => error.fmt(f),
            Self::Request(what) => f.write_str(what),
            Self::Bug(what) => write!(f, "internal error: {what}"),
        }
    }
}

impl std::error::Error for Error {
    /// The error of the package below, whose text this one has: for its type and fields.
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Format(error) => Some(error),
            Self::Select(error) => Some(error),
            #[cfg(feature = "gpu")]
            Self::Device(error) => Some(error),
            Self::Request(_) | Self::Bug(_) => None,
        }
    }
}

impl From<FormatError> for Error {
    fn from(error: FormatError) -> Self {
        Self::Format(error)
    }
}

impl From<SelectError> for Error {
    fn from(error: SelectError) -> Self {
        Self::Select(error)
    }
}

#[cfg(feature = "gpu")]
impl From<lodc_gpu::GpuError> for Error {
    fn from(error: lodc_gpu::GpuError) -> Self {
        Self::Device(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_formats::Fault;
    use std::error::Error as _;

    #[test]
    fn errors_have_their_source() {
        let error = crate::open("no such file").expect_err("it is not there");
        let source = error.source().and_then(|source| source.downcast_ref::<FormatError>());
        assert_eq!(source.map(|source| source.fault), Some(Fault::Unreadable));
        assert_eq!(Error::Request(String::new()).source().map(ToString::to_string), None);
    }
}
