//! What a collapse costs. A metric is one file or folder here and its entry in
//! [`MetricKind`](crate::MetricKind).

mod hybrid;
mod quadric;
mod visual;

pub(crate) use hybrid::HybridMetric;
pub(crate) use quadric::QuadricMetric;
pub(crate) use visual::{Score, VisualMetric};

use crate::fan::{Facet, Lanes};
use crate::neighborhood::FeaturePlane;
use crate::wedges::Wedges;
use crate::working::Working;

/// The cost of moving a group onto a neighbour. Pricing is pure, so it runs in parallel; commits
/// are serial.
pub(crate) trait Metric: Sync {
    /// Whether the metric can replace geometric costs by what is seen. What only repricing needs
    /// costs other metrics nothing.
    const REPRICES: bool = false;
    /// Data shared by all collapses of one group.
    type Local;
    /// Buffers of one thread for repricing.
    type ViewScratch: Default + Send;

    /// Prepares the collapses of a group: the faces of its star, and the planes of features through
    /// it.
    fn local(&self, from: u32, facets: &[Facet], features: &[FeaturePlane]) -> Self::Local;

    /// Costs of moving the group along the first lanes, as many as `costs` holds. Working units to
    /// the fourth power; not negative.
    fn costs(&self, local: &Self::Local, lanes: &Lanes, costs: &mut [f64]);

    /// Factor of the attributes' cost before it is added.
    fn attribute_weight(&self) -> f64 {
        1.0
    }

    /// Updates the metric for the collapse of `from` onto `to`. The faces of `from` have their new
    /// wedges already, but their groups are the old ones. May set the target's
    /// [`arrival`](crate::working::Place::arrival).
    fn collapsed(&mut self, mesh: &mut Working, wedges: &Wedges, from: u32, to: u32);

    /// Distance of the surface at `group` from the surface it stands for, in working units.
    fn error(&self, group: u32) -> f64;

    /// Whether costs are what is seen, at present.
    fn is_active(&self) -> bool {
        false
    }

    /// Returns whether visual pricing should toggle. Called after each collapse of the legal phase.
    fn should_toggle(&self, _mesh: &Working) -> bool {
        false
    }

    /// Toggles visual pricing. `legal` says whether this is the legal phase.
    fn toggle(&mut self, _mesh: &Working, _legal: bool) {}

    /// Replaces the costs of `from`'s candidates (cost and target), which come in no order.
    fn reprice(
        &self,
        _mesh: &Working,
        _wedges: &Wedges,
        _from: u32,
        _candidates: &mut [(f64, u32)],
        _scratch: &mut Self::ViewScratch,
    ) {
    }
}
