//! The result of one check: its name, how many LODs it covered, and the first failure.

use crate::difference::Failure;

/// One check that was made, and what came out.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// The model, or `sequence` for facts that are stored with the collapse sequence.
    pub model: &'static str,
    /// The name of the check.
    pub name: &'static str,
    /// At how many LODs.
    pub lods: u64,
    /// At how many of them whole meshes were compared, triangle by triangle. At the others sums of
    /// hashes were.
    pub full: u64,
    /// The first thing that is wrong.
    pub failure: Option<Failure>,
}

impl Check {
    /// Returns whether nothing was wrong.
    #[must_use]
    pub fn ok(&self) -> bool {
        self.failure.is_none()
    }
}
