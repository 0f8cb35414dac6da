//! The best collapse of a group.

use lodc_mesh::NONE;

/// Factor of a cost before it becomes a key: everything that a mesh of `f32` can cost
/// fits `f32` then.
pub(crate) const COST_SCALE: f32 = 1e12;

/// The best collapse of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    /// The scaled cost; NaN if there is no collapse.
    pub(crate) cost: f32,
    /// The group to move onto.
    pub(crate) to: u32,
}

impl Choice {
    /// No collapse at all.
    pub(crate) const NONE: Self = Self { cost: f32::NAN, to: NONE };

    /// A collapse onto `to` at a cost in working units to the fourth power. Exact zeros stay.
    pub(crate) fn new(cost: f64, to: u32) -> Self {
        Self { cost: scaled(cost), to }
    }
}

/// A cost as a key.
pub(crate) fn scaled(cost: f64) -> f32 {
    (cost * f64::from(COST_SCALE)).min(f64::from(f32::MAX)) as f32
}
