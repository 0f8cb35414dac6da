//! Errors of measurements.

use lodc_formats::FormatError;

/// Why something could not be measured.
#[derive(Clone, Debug, thiserror::Error)]
pub enum LabError {
    /// A model, a baseline or a stream cannot be made of what a simplifier made: a bug.
    #[error("{0}")]
    Bug(String),
    /// The work is more than a device or this system has room for.
    #[error("{0}")]
    Limit(String),
    /// A file's scene or animation is damaged.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A graphics device failed, or is too small.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] lodc_gpu::GpuError),
}
