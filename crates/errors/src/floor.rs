//! Errors that are stated already: a pass looks for what is above them.

/// Margin stated above the distance found, for what no sample saw. With it none of 707 measured
/// levels at rest or in stated poses is farther than stated (design-notes/errors.md).
pub(crate) const MARGIN: f64 = 1.06;

/// Errors of the steps that are stated already; none if there is nothing below a pass.
#[derive(Clone, Copy)]
pub(crate) struct Floor<'a> {
    errors: &'a [f32],
    /// Mesh units for each unit of the pass.
    unit: f64,
}

/// A stated error is raised by distances above this many times it. Less than [`MARGIN`], part of
/// which is kept for what no sample sees in this shape.
const EXCESS: f64 = 1.03;

impl<'a> Floor<'a> {
    pub(crate) fn new(errors: &'a [f32], unit: f64) -> Self {
        Self { errors, unit }
    }

    /// Returns the squared bound of the pass below which a step raises nothing.
    #[inline]
    pub(crate) fn squared(&self, step: usize) -> f64 {
        let distance = self.stated(step) / (self.unit * MARGIN) * EXCESS;
        distance * distance
    }

    /// Returns the error of a step in mesh units; 0 without one.
    pub(crate) fn stated(&self, step: usize) -> f64 {
        self.errors.get(step).map_or(0.0, |&error| f64::from(error))
    }
}
