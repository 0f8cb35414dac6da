//! Errors of the crate's public functions, sorted by whose fault they are.

use lodc_formats::FormatError;
use lodc_select::SelectError;

/// Why something failed. Displays as one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file is unreadable, malformed, unsupported or too large, or was not written.
    #[error("{0}")]
    Format(#[from] FormatError),
    /// A level that the scene does not have was asked for.
    #[error("{0}")]
    Select(#[from] SelectError),
    /// A graphics device is missing, too small or failed.
    #[cfg(feature = "gpu")]
    #[error("{0}")]
    Device(#[from] lodc_gpu::GpuError),
    /// What was asked for does not fit the file.
    #[error("{0}")]
    Request(String),
    /// A bug of this library.
    #[error("internal error: {0}")]
    Bug(String),
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
