//! The reference, kept incrementally: every triangle is followed through every record by itself.
//!
//! Shares no code with any model: see [`follow`](super::follow) for how.

use super::follow::Follower;
use super::{Check, facts};
use lodc_mesh::{Lod, Simplified, TriangleHash};
use std::fmt;

/// The hash of the reference at every step, and whatever is wrong with the sequence itself.
#[derive(Clone, Debug)]
pub struct Reference<'a> {
    simplified: &'a Simplified,
    /// At LOD 0 and after each step.
    hashes: Vec<TriangleHash>,
    checks: Vec<Check>,
}

/// A sequence moves so many corners of live triangles that following them would take very long.
/// Real ones move each about ten times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooMuchWork {
    /// The LOD at which it became too much.
    pub lod: Lod,
}

impl fmt::Display for TooMuchWork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "up to LOD {} corners move more often than can be verified", self.lod.0)
    }
}

impl std::error::Error for TooMuchWork {}

impl<'a> Reference<'a> {
    /// Follows all triangles from LOD 0 to the last. Time in proportion to how often corners of
    /// live triangles move.
    ///
    /// # Errors
    /// If that is more than some hundred times per corner.
    pub fn new(simplified: &'a Simplified) -> Result<Self, TooMuchWork> {
        let mut follower = Follower::new(simplified);
        let mut hashes = Vec::with_capacity(simplified.collapses().steps() + 1);
        hashes.push(follower.hash());
        for step in 0..simplified.collapses().steps() {
            follower.step(step)?;
            hashes.push(follower.hash());
        }
        let positions = follower.positions().clone();
        let mut checks = follower.finish();
        checks.extend(facts::check(simplified, &positions));
        Ok(Self { simplified, hashes, checks })
    }

    /// What was found out about the sequence itself: stored triangle counts, order of triangles,
    /// tears, dead triangles that return, submeshes, steps that do not move one position onto one
    /// position, fakes out of place.
    #[must_use]
    pub fn checks(&self) -> &[Check] {
        &self.checks
    }

    /// Number of steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.hashes.len() - 1
    }

    /// The LOD after so many steps.
    #[must_use]
    pub fn lod(&self, steps: usize) -> Lod {
        if steps == 0 { Lod(0) } else { self.simplified.collapses().step(steps - 1).lod }
    }

    /// The hash of the triangles after so many steps.
    #[must_use]
    pub fn hash(&self, steps: usize) -> TriangleHash {
        self.hashes[steps]
    }
}
