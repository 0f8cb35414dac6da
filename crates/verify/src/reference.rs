//! The reference, kept incrementally: every triangle is followed through every record by itself.
//!
//! Shares no code with any model: see `track.rs` for how.

use crate::check::Check;
use crate::difference::{Failure, first_difference};
use crate::facts;
use crate::track::{TooMuchWork, Tracker};
use lodc_mesh::{Lod, OrientedTriangle, PositionIds, Simplified, TriangleHash};
use std::sync::OnceLock;

/// The hash of the reference at every step, and the checks of the sequence itself.
#[derive(Clone, Debug)]
pub struct Reference<'a> {
    simplified: &'a Simplified,
    positions: PositionIds,
    /// The hashes at LOD 0 and after each step.
    hashes: Vec<TriangleHash>,
    /// Whether the naive list has that hash, for steps for which it was asked.
    list_agrees: Vec<OnceLock<bool>>,
    checks: Vec<Check>,
}

impl<'a> Reference<'a> {
    /// Follows all triangles from LOD 0 to the last. Time in proportion to how often corners of
    /// live triangles move.
    ///
    /// # Errors
    /// If they move more than some hundred times per corner.
    pub fn new(simplified: &'a Simplified) -> Result<Self, TooMuchWork> {
        let mut tracker = Tracker::new(simplified);
        let mut hashes = Vec::with_capacity(simplified.collapses().steps() + 1);
        hashes.push(tracker.hash());
        for step in 0..simplified.collapses().steps() {
            tracker.apply_step(step)?;
            hashes.push(tracker.hash());
        }
        let positions = tracker.positions().clone();
        let mut checks = tracker.finish();
        checks.extend(facts::check(simplified, &positions));
        let list_agrees = vec![OnceLock::new(); hashes.len()];
        Ok(Self { simplified, positions, hashes, list_agrees, checks })
    }

    /// Returns the checks of the sequence itself: stored triangle counts, order of triangles,
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

    /// The LOD after `steps` steps.
    #[must_use]
    pub fn lod(&self, steps: usize) -> Lod {
        if steps == 0 { Lod(0) } else { self.simplified.collapses().step(steps - 1).lod }
    }

    /// The hash of the triangles after `steps` steps.
    #[must_use]
    pub fn hash(&self, steps: usize) -> TriangleHash {
        self.hashes[steps]
    }

    /// What is wrong with triangles shown at a LOD that is the end of a step, if anything: their
    /// hash is compared, and only if it differs are they listed.
    #[must_use]
    pub fn judge(
        &self,
        lod: Lod,
        hash: TriangleHash,
        shown: impl FnOnce() -> Vec<OrientedTriangle>,
    ) -> Option<Failure> {
        let steps = self.simplified.collapses().steps_at(lod);
        if hash == self.hashes[steps] {
            return None;
        }
        first_difference(lod, self.list(steps), shown()).or(Some(Failure::Reference { lod }))
    }

    /// Returns whether the naive function lists the triangles that were followed. It is called once
    /// for each step, however many models and walks stop there.
    pub(super) fn list_agrees(&self, steps: usize) -> bool {
        let agrees =
            || self.list(steps).into_iter().collect::<TriangleHash>() == self.hashes[steps];
        *self.list_agrees[steps].get_or_init(agrees)
    }

    /// The triangles after `steps` steps by the naive function.
    pub(super) fn list(&self, steps: usize) -> Vec<OrientedTriangle> {
        self.simplified.triangles_at_with(self.lod(steps), &self.positions)
    }
}
