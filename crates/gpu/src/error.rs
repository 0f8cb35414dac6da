//! Errors of a graphics device, by whose fault they are.

use std::fmt;

/// Why a device did not do what it was asked.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter at all.
    NoAdapter {
        /// The message of the system.
        why: String,
    },
    /// There are adapters, but none whose name has the wanted part.
    NoMatch {
        /// The part.
        wanted: String,
        /// Names of those that there are.
        available: Vec<String>,
    },
    /// An adapter gave no device.
    Refused {
        /// Its name.
        adapter: String,
        /// Its message.
        why: String,
    },
    /// The device allows less than is needed.
    Limit {
        /// For what.
        what: String,
        /// The limit, as WebGPU calls it.
        limit: &'static str,
        /// The amount needed.
        needed: u64,
        /// The amount allowed.
        allowed: u64,
    },
    /// The device does not take a kernel or a command: a bug of this program or of the driver.
    Invalid {
        /// Its message.
        why: String,
    },
    /// The device ran out of memory.
    OutOfMemory,
    /// The device was lost or does not answer.
    Lost {
        /// Its message.
        why: String,
    },
}

impl fmt::Display for GpuError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAdapter { why } => {
                write!(f, "no graphics adapter: {why} ")?;
                f.write_str("(on Debian, mesa-vulkan-drivers has one that needs no hardware)")
            }
            Self::NoMatch { wanted, available } => {
                write!(
                    f,
                    "no graphics adapter is called {wanted:?}; there are: {}",
                    available.join(", ")
                )
            }
            Self::Refused { adapter, why } => write!(f, "{adapter} gives no device: {why}"),
            Self::Limit { what, limit, needed, allowed } => {
                write!(
                    f,
                    "{what} needs {needed}, and the graphics device allows {allowed} ({limit})"
                )
            }
            Self::Invalid { why } => write!(f, "the graphics device refuses: {why}"),
            Self::OutOfMemory => write!(f, "the graphics device has no memory left"),
            Self::Lost { why } => write!(f, "the graphics device is lost: {why}"),
        }
    }
}

impl std::error::Error for GpuError {}
