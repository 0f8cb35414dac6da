//! Limits of the work that any mesh may take, counted as [`Work`].

use crate::input::Input;
use std::ops::Add;

/// Work for each input triangle after which the pass gives up: the steps that are left are measured
/// level by level. Real meshes need less than a third.
const LIMIT_PER_TRIANGLE: u64 = 1_000;

/// Work that any mesh may take besides, so that small ones are never given up.
const LIMIT_BESIDES: u64 = 10_000_000;

/// Boxes that one search for a near triangle may open: at first, and once half of the work is done.
/// A search that ends early gives distances that are too large, never too small. Chosen by hand.
const BOXES_NEAREST: [u32; 2] = [20_000, 64];

/// The same for a search for the farthest point of a triangle.
const BOXES_FARTHEST: [u64; 2] = [4_000, 200];

/// Squared distances below this are rounding errors: the square of 2⁻⁴⁴ of the diagonal.
pub(crate) const ROUNDING_SQUARED: f64 = 3.0e-27;

/// Work done: faces touched, samples moved, distances to faces and boxes opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Work(pub(crate) u64);

impl Work {
    /// Returns whether the pass gives up.
    pub(crate) fn exceeds_limit(self, input: &Input) -> bool {
        self.0 > limit(input)
    }

    /// Returns how many boxes one search for a near triangle may open.
    pub(crate) fn boxes_nearest(self, input: &Input) -> u32 {
        BOXES_NEAREST[usize::from(self.is_half_done(input))]
    }

    /// Returns how many boxes one search for the farthest point of a triangle may open.
    pub(crate) fn boxes_farthest(self, input: &Input) -> u64 {
        BOXES_FARTHEST[usize::from(self.is_half_done(input))]
    }

    fn is_half_done(self, input: &Input) -> bool {
        self.0 > limit(input) / 2
    }
}

impl Add for Work {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

fn limit(input: &Input) -> u64 {
    LIMIT_PER_TRIANGLE * input.triangles.len() as u64 + LIMIT_BESIDES
}
