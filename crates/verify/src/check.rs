//! The result of one check: its name, how many LODs it covered, and the first failure.

use crate::difference::Failure;

/// One check that was made, and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// The model, or `sequence` for facts that are stored with the collapse sequence.
    pub model: &'static str,
    /// The name of the check.
    pub name: &'static str,
    /// Number of LODs that were compared.
    pub lods: u64,
    /// Number of LODs at which whole meshes were compared, triangle by triangle; at the others sums
    /// of hashes were. 0 for facts that are stored with the sequence.
    pub full: u64,
    /// The first failure; none if there is none.
    pub failure: Option<Failure>,
}

impl Check {
    /// Returns whether there is no failure.
    #[must_use]
    pub fn ok(&self) -> bool {
        self.failure.is_none()
    }
}
