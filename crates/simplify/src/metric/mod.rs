//! What a collapse costs. A metric is one file or folder here and its entry in [`MetricKind`](crate::MetricKind).

mod quadric;

pub(crate) use quadric::QuadricMetric;

use crate::fan::{Facet, Lanes, MAX_FAN};
use crate::neighborhood::FeaturePlane;
use crate::working::Working;

/// The price of moving a group onto a neighbour. Pricing is pure, so it runs in parallel; committing is serial.
pub(crate) trait Metric: Sync {
    /// What is common to all collapses of one group.
    type Local;

    /// Looks at a group: the faces of its star, and the planes of features through it.
    fn local(&self, from: u32, facets: &[Facet], features: &[FeaturePlane]) -> Self::Local;

    /// What it costs to move the group along each of the first `count` lanes, at most [`MAX_FAN`]. Working units to the
    /// fourth power; not negative. Lanes beyond `count` may be priced too.
    fn costs(&self, local: &Self::Local, lanes: &Lanes, count: usize) -> [f64; MAX_FAN];

    /// `from` is about to move onto `to`. May set the target's [`arrival`](crate::working::Place::arrival).
    fn collapsed(&mut self, mesh: &mut Working, from: u32, to: u32);

    /// How far the surface at `group` is from the surface it stands for, in working units.
    fn error(&self, group: u32) -> f64;
}
