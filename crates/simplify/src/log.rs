//! What is written down while collapsing, in the order in which it happens.

use lodc_mesh::Lod;

/// What is written down while collapsing.
#[derive(Default)]
pub(crate) struct Log {
    /// Wedges in the order in which they disappear.
    pub(crate) order: Vec<u32>,
    /// What each becomes.
    pub(crate) targets: Vec<u32>,
    pub(crate) step_ends: Vec<u32>,
    /// In working units, never falling.
    pub(crate) step_errors: Vec<f64>,
    pub(crate) step_triangles: Vec<u32>,
    /// The LOD at which each input triangle dies.
    pub(crate) death: Vec<u32>,
    pub(crate) last_legal: Lod,
    pub(crate) topology_changes: u32,
    pub(crate) first_topology_change: Option<Lod>,
}
