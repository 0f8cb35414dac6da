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
use crate::working::Working;

/// The price of moving a group onto a neighbour. Pricing is pure, so it runs in parallel;
/// committing is serial.
pub(crate) trait Metric: Sync {
    /// Whether it can look: see more than a group's planes. What only looking needs costs the
    /// others nothing.
    const LOOKS: bool = false;
    /// What is common to all collapses of one group.
    type Local;
    /// Buffers for looking, one thread's.
    type Eye: Default + Send;

    /// Looks at a group: the faces of its star, and the planes of features through it.
    fn local(&self, from: u32, facets: &[Facet], features: &[FeaturePlane]) -> Self::Local;

    /// What it costs to move the group along the first lanes, as many as `costs` holds. Working
    /// units to the fourth power; not negative.
    fn costs(&self, local: &Self::Local, lanes: &Lanes, costs: &mut [f64]);

    /// What the cost of attributes is multiplied by before it is added.
    fn attribute_weight(&self) -> f64 {
        1.0
    }

    /// `from` is about to move onto `to`. May set the target's
    /// [`arrival`](crate::working::Place::arrival).
    fn collapsed(&mut self, mesh: &mut Working, from: u32, to: u32);

    /// How far the surface at `group` is from the surface it stands for, in working units.
    fn error(&self, group: u32) -> f64;

    /// Whether prices are what is seen, at present.
    fn is_awake(&self) -> bool {
        false
    }

    /// Asked after every collapse while every rule holds: whether prices should from now on, or no
    /// longer, be what is seen.
    fn wants_change(&self, _mesh: &Working) -> bool {
        false
    }

    /// Makes that change. `legal` says that every rule holds.
    fn change(&mut self, _mesh: &Working, _legal: bool) {}

    /// Replaces the prices of `from`'s candidates (cost and target), which come in no order.
    fn look(
        &self,
        _mesh: &Working,
        _from: u32,
        _candidates: &mut [(f64, u32)],
        _eye: &mut Self::Eye,
    ) {
    }
}
