//! Work of a pass, counted to limit it, and what is too small to count.

use std::ops::Add;

/// Squared distances below this are rounding errors: the square of 2⁻⁴⁴ of the diagonal.
pub(crate) const ROUNDING_SQUARED: f64 = 3.0e-27;

/// Work done: faces touched, samples moved, distances to faces and boxes opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Work(pub(crate) u64);

impl Add for Work {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}
