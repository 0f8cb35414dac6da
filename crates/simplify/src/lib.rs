//! Half-edge simplification over wedge groups, driven by a metric, down to a single vertex.

use lodc_mesh::{Mesh, Simplified};

/// What drives the collapses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MetricKind {
    /// Distance to planes, refitted to the current surface, with a small accumulated term.
    #[default]
    Quadric,
}

/// What a simplification respects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What drives the collapses.
    pub metric: MetricKind,
    /// No topology change before the terminal phase.
    pub preserve_topology: bool,
    /// Border vertices stay until the terminal phase.
    pub lock_border: bool,
    /// Whether attributes take part in the cost.
    pub attributes: bool,
}

impl Options {
    /// The defaults.
    pub const DEFAULT: Self =
        Self { metric: MetricKind::Quadric, preserve_topology: false, lock_border: false, attributes: true };
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Simplifies a mesh down to one vertex. `progress` is told (groups gone, groups in all) now and then. The result does
/// not depend on the number of threads.
#[must_use]
pub fn simplify(mesh: &Mesh, options: &Options, progress: &(dyn Fn(u64, u64) + Sync)) -> Simplified {
    let _ = (mesh, options, progress);
    unreachable!("under construction")
}
