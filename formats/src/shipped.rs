//! Levels that this program wrote, read back.

use crate::Scene;
use crate::provenance::Provenance;

/// A file of one level or of several, as `extract` and `chain` write them.
#[derive(Clone, Debug)]
pub struct ShippedLevels {
    /// What it says of itself.
    pub stated: Provenance,
    /// Each level as a scene of its own, as many as are stated.
    pub levels: Vec<Scene>,
    /// What the levels of one file do not share although they should, and where.
    pub difference: Option<String>,
}
