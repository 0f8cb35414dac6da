//! The metrics: what a collapse costs.
//!
//! The quadric prices every collapse: squared distances to planes, refitted to the faces around the
//! group (`quadric`). A metric that sees prices the cheapest of them anew: by what changes in
//! pictures from all sides (`visual`), or by the error of the shaded surface where it is seen
//! (`hybrid`). Pricing changes nothing, so threads share a metric; it is told of each collapse at
//! once, so that it prices the current mesh. A metric is one file or folder here and its entry in
//! [`MetricKind`](crate::MetricKind).

mod hybrid;
mod quadric;
mod reevaluate;
mod visual;

pub(crate) use hybrid::HybridMetric;
pub use hybrid::{Checkerboard, SurfaceColours};
pub(crate) use quadric::{MEMORY, QuadricOnly, TIE_WEIGHT};
pub(crate) use reevaluate::Reevaluate;
pub(crate) use visual::{Score, VisualMetric};
