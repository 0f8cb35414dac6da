//! The errors of plans that no device can run, and the longest loop that a kernel may have.

use std::fmt;

/// Why there is no plan for a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PlanError {
    /// A buffer would have too many words for 32-bit numbers.
    TooLarge {
        /// The content.
        what: &'static str,
        /// Number of words.
        words: u64,
    },
    /// A vertex collapses more times in a row than a kernel may loop on every device.
    TooDeep {
        /// Its length.
        length: u32,
    },
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLarge { what, words } => write!(f, "{what} would take {words} words"),
            Self::TooDeep { length } => {
                write!(f, "a vertex collapses {length} times, ")?;
                write!(f, "more than the {LONGEST_LOOP} a kernel may loop")
            }
        }
    }
}

impl std::error::Error for PlanError {}

/// The most rounds of a kernel's loops. Mesa's lavapipe silently leaves all loops of an invocation
/// after 65,535 rounds.
pub const LONGEST_LOOP: u32 = 60_000;
