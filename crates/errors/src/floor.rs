//! Errors that are stated already: a pass looks for what is above them.

/// Stated error over the distance found, for what no sample saw. With it none of 707 measured
/// levels at rest or in stated poses is farther than stated (docs/design-notes/errors.md).
pub(crate) const MARGIN: f64 = 1.06;

/// Distances above this many times a stated error, before its [`MARGIN`], raise it. Less than
/// [`MARGIN`]: the rest is for what no sample sees in this shape. Chosen by hand.
const RAISING_EXCESS: f64 = 1.03;

/// The errors of steps that are stated already; none in the first shape that is measured.
#[derive(Clone, Copy)]
pub(crate) struct Floor<'a> {
    /// One for each step, in mesh units; or empty.
    errors: &'a [f32],
    /// Mesh units per unit of the pass.
    mesh_scale: f64,
}

impl<'a> Floor<'a> {
    pub(crate) fn new(errors: &'a [f32], mesh_scale: f64) -> Self {
        Self { errors, mesh_scale }
    }

    /// Returns the squared distance, in units of the pass, up to which a step raises nothing.
    #[inline]
    pub(crate) fn squared(&self, step: usize) -> f64 {
        let distance = self.stated(step) / (self.mesh_scale * MARGIN) * RAISING_EXCESS;
        distance * distance
    }

    /// Returns the stated error of a step in mesh units; 0 without one.
    pub(crate) fn stated(&self, step: usize) -> f64 {
        self.errors.get(step).map_or(0.0, |&error| f64::from(error))
    }
}
