//! Limits of the work that any mesh may take.

use crate::input::Input;
use std::ops::Add;

/// Work for each input triangle, in faces touched, distances to faces and boxes opened, after which
/// the pass gives up: the steps that are left are measured directly. Real meshes need less than a
/// third.
const PER_TRIANGLE: u64 = 1_000;

/// Work that any mesh may take besides, so that small ones are never given up.
const FREE: u64 = 10_000_000;

/// Boxes that one search may open: many, and few once half of the work is done. A search that ends
/// early gives distances that are too large, never too small. Chosen by hand.
pub(crate) const PATIENCE: [u32; 2] = [20_000, 64];

/// The same for the search for the farthest point of a triangle.
const BOXES: [u64; 2] = [4_000, 200];

/// Squared distances below this are rounding errors: 2⁻⁴⁴ of the diagonal.
pub(crate) const FLOOR: f64 = 3.0e-27;

/// Work done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Work {
    /// Faces touched, distances to faces and boxes opened.
    pub(crate) done: u64,
}

impl Work {
    /// Returns whether the pass gives up.
    pub(crate) fn is_too_much(self, input: &Input) -> bool {
        self.done > most(input)
    }

    /// Returns how many boxes one search may open.
    pub(crate) fn patience(self, input: &Input) -> u32 {
        PATIENCE[usize::from(self.done > most(input) / 2)]
    }

    /// Returns how many boxes the search for the farthest point of a triangle may open.
    pub(crate) fn boxes(self, input: &Input) -> u64 {
        BOXES[usize::from(self.done > most(input) / 2)]
    }
}

impl Add for Work {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { done: self.done + other.done }
    }
}

fn most(input: &Input) -> u64 {
    PER_TRIANGLE * input.triangles.len() as u64 + FREE
}
