//! The cost of collapses. The quadric prices every collapse; a visual metric may price it anew by
//! what is seen. A metric is one file or folder here and its entry in
//! [`MetricKind`](crate::MetricKind).

mod hybrid;
mod quadric;
mod visual;

pub(crate) use hybrid::HybridMetric;
pub use hybrid::{Checkerboard, SurfaceColours};
pub(crate) use quadric::{MEMORY, Quadrics, TIE_WEIGHT};
pub(crate) use visual::{Score, VisualMetric};

use crate::cut::mesh::WorkingMesh;
use crate::cut::wedges::Wedges;

/// Prices collapses anew that the quadric has priced. Pricing is pure, so it runs in parallel;
/// committing is serial.
pub(crate) trait Reprice: Sync {
    /// False if it never does.
    const REPRICES: bool = true;
    /// True if a price stays as it is until something next to the group changes.
    const IS_LOCAL: bool = true;
    /// Buffers of one thread.
    type ViewScratch: Default + Send;

    /// Returns whether it does at present.
    fn is_active(&self) -> bool;

    /// Returns whether pricing should toggle. Called after each collapse of the legal phase.
    fn should_toggle(&self, mesh: &WorkingMesh) -> bool;

    /// Starts or ends pricing. `legal` says that every rule holds.
    fn toggle(&mut self, mesh: &WorkingMesh, legal: bool);

    /// Factor of the attributes' cost before it is added.
    fn attribute_weight(&self) -> f64 {
        1.0
    }

    /// Replaces the costs of `from`'s candidates (cost and target), which come in no order.
    fn reprice(
        &self,
        mesh: &WorkingMesh,
        wedges: &Wedges,
        from: u32,
        candidates: &mut [(f64, u32)],
        scratch: &mut Self::ViewScratch,
    );

    /// Updates the metric for the collapse of `from` onto `to`. The faces of `from` have their new
    /// wedges already, but their groups are the old ones.
    fn collapsed(&mut self, mesh: &WorkingMesh, wedges: &Wedges, from: u32, to: u32);

    /// The error of the last collapse in working units, if it is not the quadric's.
    fn error(&self) -> Option<f64> {
        None
    }
}

/// The quadric's costs as they are.
pub(crate) struct QuadricOnly;

impl Reprice for QuadricOnly {
    const REPRICES: bool = false;
    type ViewScratch = ();

    fn is_active(&self) -> bool {
        false
    }
    fn should_toggle(&self, _mesh: &WorkingMesh) -> bool {
        false
    }
    fn toggle(&mut self, _mesh: &WorkingMesh, _legal: bool) {}
    fn reprice(&self, _: &WorkingMesh, _: &Wedges, _: u32, _: &mut [(f64, u32)], (): &mut ()) {}
    fn collapsed(&mut self, _: &WorkingMesh, _: &Wedges, _: u32, _: u32) {}
}
