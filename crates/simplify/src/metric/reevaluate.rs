//! The trait of metrics, which re-evaluate what the quadric has priced, and the cameras of those
//! that judge by pictures.

use crate::cut::{Wedges, WorkingMesh};
use crate::recorded::RecordedCollapse;
use glam::DVec3;
use lodc_raster::{Camera, metric_cameras};

/// Prices collapses anew that the quadric has priced. Pricing is pure, so it runs in parallel;
/// committing is serial.
pub(crate) trait Reevaluate: Sync {
    /// False if the metric never re-evaluates.
    const REPRICES: bool = true;
    /// True if a price holds until something next to the group changes.
    const IS_LOCAL: bool = true;
    /// Buffers of one thread.
    type ViewScratch: Default + Send;

    /// Returns whether the metric re-evaluates at present.
    fn is_active(&self) -> bool;

    /// Returns whether reevaluating should start or end now. Called after each collapse.
    fn activity_changes(&self, mesh: &WorkingMesh) -> bool;

    /// Starts or ends reevaluating, if that is due now. `legal` says that the legal phase is on, in
    /// which every rule holds.
    fn update_activity(&mut self, mesh: &WorkingMesh, legal: bool);

    /// The collapse that is to be the `i`-th one whatever the prices are, if one is given.
    fn given(&self, _mesh: &WorkingMesh, _i: usize) -> Option<RecordedCollapse> {
        None
    }

    /// Factor of the attributes' cost before it is added.
    fn attribute_weight(&self) -> f64 {
        1.0
    }

    /// Factor of what a collapse costs more in motion than at rest, before that is added.
    fn motion_weight(&self) -> f64 {
        1.0
    }

    /// Replaces the costs of `from`'s candidates (cost and target), which come in no order. With
    /// `only_cheapest`, the costs of others need not be right, only higher than the cheapest.
    fn reevaluate(
        &self,
        mesh: &WorkingMesh,
        wedges: &Wedges,
        from: u32,
        candidates: &mut [(f64, u32)],
        only_cheapest: bool,
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

/// The cameras of metrics that see, around the sphere about the middle of the bounding box. `size`
/// is the number of pixels across each picture.
pub(super) fn cameras(mesh: &WorkingMesh, size: u32) -> Vec<Camera> {
    let points = || mesh.group_positions.iter().map(|p| p.position.as_dvec3());
    let (lo, hi) =
        points().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)));
    let center = 0.5 * (lo + hi);
    let radius = points().map(|p| p.distance(center)).fold(0.0, f64::max);
    metric_cameras(center, radius, size)
}
