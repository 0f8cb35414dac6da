//! The errors of plans that no device can run, and the longest loop that a kernel may have.

/// Why there is no plan for a mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// A buffer would have too many words for 32-bit numbers.
    #[error("{what} would take {words} words")]
    TooLarge {
        /// The content.
        what: &'static str,
        /// Number of words.
        words: u64,
    },
    /// A kernel would loop more often than it may on every device.
    #[error("{what} takes {rounds} rounds of a kernel's loop, more than {most}")]
    TooDeep {
        /// What the loop follows.
        what: &'static str,
        /// Number of rounds.
        rounds: u32,
        /// The most that there may be.
        most: u32,
    },
}

/// The most rounds of a kernel's loops. Mesa's lavapipe silently leaves all loops of an invocation
/// after 65,535 rounds.
pub const LONGEST_LOOP: u32 = 60_000;
