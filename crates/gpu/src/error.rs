//! Errors of a graphics device, by whose fault they are.

/// Why a device did not do what it was asked.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter at all.
    #[error(
        "no graphics adapter: {why} (on Debian, mesa-vulkan-drivers has one that needs no hardware)"
    )]
    NoAdapter {
        /// The message of the system.
        why: String,
    },
    /// There are adapters, but none whose name has the wanted part.
    #[error("no graphics adapter is called {wanted:?}; there are: {}", available.join(", "))]
    NoMatch {
        /// The part.
        wanted: String,
        /// Names of those that there are.
        available: Vec<String>,
    },
    /// An adapter gave no device.
    #[error("{adapter} gives no device: {why}")]
    Refused {
        /// Its name.
        adapter: String,
        /// Its message.
        why: String,
    },
    /// The device allows less than is needed.
    #[error("{what} needs {needed}, and the graphics device allows {allowed} ({limit})")]
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
    #[error("the graphics device refuses: {why}")]
    Invalid {
        /// Its message.
        why: String,
    },
    /// The device ran out of memory.
    #[error("the graphics device has no memory left")]
    OutOfMemory,
    /// The device was lost or does not answer.
    #[error("the graphics device is lost: {why}")]
    Lost {
        /// Its message.
        why: String,
    },
}
