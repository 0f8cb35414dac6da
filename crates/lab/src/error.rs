//! Errors of measurements.

use lodc_formats::FormatError;
use std::fmt;

/// Why something could not be measured.
#[derive(Clone, Debug)]
pub enum LabError {
    /// A model, a baseline or a stream cannot be made of what a simplifier made: a bug.
    Bug(String),
    /// The work is more than a device or this system has room for.
    Limit(String),
    /// A file's scene or animation is damaged.
    Format(FormatError),
    /// A graphics device failed, or is too small.
    #[cfg(feature = "gpu")]
    Gpu(lodc_gpu::GpuError),
}

impl fmt::Display for LabError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bug(what) | Self::Limit(what) => f.write_str(what),
            Self::Format(error) => error.fmt(f),
            #[cfg(feature = "gpu")]
            Self::Gpu(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for LabError {}

impl From<FormatError> for LabError {
    fn from(error: FormatError) -> Self {
        Self::Format(error)
    }
}

#[cfg(feature = "gpu")]
impl From<lodc_gpu::GpuError> for LabError {
    fn from(error: lodc_gpu::GpuError) -> Self {
        Self::Gpu(error)
    }
}
