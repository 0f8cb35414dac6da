//! Verification of any model against the reference, at every step and in near-linear time.
//!
//! Comparing whole meshes at every step would take quadratic time. So every step is compared by an
//! order-independent hash, kept incrementally on both sides: by the changes that the model reports,
//! and by [`Reference`], which follows the triangles by itself. At some stops (both ends and a grid
//! between) the model lists all triangles that it shows, going coarser, going finer and after
//! seeded jumps, and so does [`Simplified::triangles_at`](lodc_mesh::Simplified::triangles_at),
//! once for all models and walks: both lists must have the hash that was followed. That also
//! catches a model that misreports its changes, and a reference that followed wrongly.
//!
//! A difference is missed where two multisets of triangles have the same [`TriangleHash`], a sum of
//! 128-bit hashes: for two that differ by chance with probability 2⁻¹²⁸, so in all comparisons of a
//! file of 10⁶ steps and four walks with less than 10⁻³¹. The hash has no secret: it finds faults,
//! not someone who searches for two meshes with one sum. Where hashes differ the lists are sorted,
//! and the first triangle in which they do is named.
//!
//! ```
//! use lodc_lod::Interactive;
//! use lodc_verify::{Reference, VerifyOptions, verify};
//! use std::sync::Arc;
//!
//! let simplified = Arc::new(lodc_fixtures::random_collapse(&lodc_fixtures::cube(), 1));
//! let model = Interactive::build(&simplified)?;
//! let reference = Reference::new(&simplified)?;
//! let checks = verify(&model, &reference, &VerifyOptions::default());
//! assert!(checks.iter().chain(reference.checks()).all(|check| check.ok()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod boundary;
mod check;
mod difference;
mod facts;
mod reference;
#[cfg(test)]
mod sequence_tests;
mod source;
#[cfg(test)]
mod tests;
mod ties;
mod track;
mod view;

pub use check::Check;
pub use difference::{Failure, first_difference};
pub use reference::Reference;
pub use source::source_difference;
pub use track::TooMuchWork;
pub use view::{ShownView, ViewReference};

use lodc_mesh::{Lod, OrientedTriangle, SplitMix64, TriangleHash};
use lodc_model::{Changes, Model};

/// The thoroughness of a verification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerifyOptions {
    /// Compare at every `stride`-th step (0 means 1). The last step is always compared.
    pub stride: u32,
    /// Full comparisons on the way to coarser levels, and as many on the way to finer ones, if the
    /// mesh is too large for one at every step. Fewer, but at least [`Self::MIN_FULL`], on meshes
    /// of more than some hundred thousand triangles.
    pub full_stops: u32,
    /// Random jumps to the full stops, each followed by a full comparison. Fewer where there are
    /// fewer full stops.
    pub jumps: u32,
    /// The seed of the jumps' order.
    pub seed: u64,
}

impl VerifyOptions {
    /// The smallest number of full comparisons, however large a mesh is. Chosen by hand.
    pub const MIN_FULL: u32 = 16;

    /// Returns the number of full comparisons that a mesh of `triangles` triangles gets, if
    /// `wanted` are asked for.
    fn affordable(wanted: u32, triangles: usize) -> u32 {
        let affordable = u32::try_from(MAX_LISTED / triangles.max(1)).unwrap_or(u32::MAX);
        wanted.min(affordable.max(Self::MIN_FULL))
    }
}

/// Triangles that all full comparisons of one walk go over: a few seconds of work. Chosen by hand.
const MAX_LISTED: usize = 50_000_000;

/// If steps times triangles are at most this, each step is compared in full, which takes about a
/// second. Chosen by hand.
const MAX_EXHAUSTIVE: usize = 8_000_000;

impl Default for VerifyOptions {
    fn default() -> Self {
        Self { stride: 1, full_stops: 100, jumps: 100, seed: 1 }
    }
}

/// Compares a model with the reference at every step going coarser, at every step going finer, and
/// after random jumps, all three at once with a cursor each. `reference` must have been made of the
/// simplification that the model was built from.
#[must_use]
pub fn verify<M: Model + Sync>(
    model: &M,
    reference: &Reference<'_>,
    options: &VerifyOptions,
) -> Vec<Check> {
    let comparison = Comparison { model, reference };
    let steps = reference.steps();
    let stride = options.stride.max(1) as usize;
    let mut stops: Vec<usize> = (0..=steps).step_by(stride).collect();
    if stops.last() != Some(&steps) {
        stops.push(steps);
    }
    let triangles = model.simplified().mesh().triangles().len();
    let full_stride = match (steps + 1).saturating_mul(triangles) {
        0..=MAX_EXHAUSTIVE => 1,
        _ => stops
            .len()
            .div_ceil(VerifyOptions::affordable(options.full_stops, triangles).max(1) as usize),
    };
    // All walks compare in full at the same steps: the naive list of each is made once.
    let last = stops.len() - 1;
    let is_full = |number: usize| number.is_multiple_of(full_stride) || number == last;
    let coarser = stops.iter().enumerate().map(|(number, &step)| (step, is_full(number)));
    let full_steps: Vec<usize> =
        coarser.clone().filter_map(|(step, is_full)| is_full.then_some(step)).collect();
    let ((down, up), jumps) = rayon::join(
        || {
            rayon::join(
                || comparison.sweep("fine to coarse", coarser.clone()),
                || comparison.sweep("coarse to fine", coarser.clone().rev()),
            )
        },
        || comparison.jumps(full_steps, options),
    );
    vec![down, up, jumps]
}

struct Comparison<'a, M> {
    model: &'a M,
    reference: &'a Reference<'a>,
}

/// Listener that follows a model by the changes that it reports.
struct HashFollower<'a>(&'a mut TriangleHash);

impl Changes for HashFollower<'_> {
    fn removed(&mut self, triangle: OrientedTriangle) {
        self.0.remove(triangle);
    }
    fn added(&mut self, triangle: OrientedTriangle) {
        self.0.add(triangle);
    }
}

impl<M: Model> Comparison<'_, M> {
    /// Visits steps in order, from LOD 0 with one jump to the first of them. Each comes with
    /// whether it is compared in full.
    fn sweep(&self, name: &'static str, stops: impl Iterator<Item = (usize, bool)>) -> Check {
        let mut cursor = self.model.cursor();
        let mut hash = self.listed_hash(&cursor);
        let mut check = Check { model: self.model.name(), name, lods: 0, full: 0, failure: None };
        for (step, is_full) in stops {
            let lod = self.reference.lod(step);
            self.model.seek(&mut cursor, lod, &mut HashFollower(&mut hash));
            let agrees = hash == self.reference.hash(step);
            if !agrees || is_full {
                check.full += 1;
                check.failure =
                    self.compare(&cursor, step).or((!agrees).then_some(Failure::Changes { lod }));
            }
            check.lods += 1;
            if check.failure.is_some() {
                break;
            }
        }
        check
    }

    /// Visits steps in a random order, again and again if they are few.
    fn jumps(&self, mut steps: Vec<usize>, options: &VerifyOptions) -> Check {
        let mut cursor = self.model.cursor();
        let mut check = Check {
            model: self.model.name(),
            name: "random jumps",
            lods: 0,
            full: 0,
            failure: None,
        };
        let mut random = SplitMix64::new(options.seed);
        let mut below = |count: usize| ((random.bits() >> 32) as usize) % count;
        let triangles = self.model.simplified().mesh().triangles().len();
        let records = self.model.simplified().collapses().records() as usize;
        for jump in 0..VerifyOptions::affordable(options.jumps, triangles) as usize {
            let index = jump % steps.len();
            let chosen = index + below(steps.len() - index);
            steps.swap(index, chosen);
            let step = steps[index];
            // Any record may be asked for; the model has to round down to a step.
            let lod = self.reference.lod(step).0 as usize;
            let next = if step < self.reference.steps() {
                self.reference.lod(step + 1).0 as usize
            } else {
                records + 1
            };
            self.model.seek(&mut cursor, Lod((lod + below(next - lod)) as u32), &mut ());
            check.lods += 1;
            check.full += 1;
            check.failure = self.compare(&cursor, step);
            if check.failure.is_some() {
                break;
            }
        }
        check
    }

    /// The full comparison: of all triangles that are shown, listed anew.
    fn compare(&self, cursor: &M::Cursor, step: usize) -> Option<Failure> {
        let wanted = self.reference.lod(step);
        let shown = self.model.lod(cursor);
        if shown != wanted {
            return Some(Failure::Stopped { wanted, shown });
        }
        if !self.reference.list_agrees(step) {
            return Some(Failure::Reference { lod: wanted });
        }
        if self.listed_hash(cursor) == self.reference.hash(step) {
            return None;
        }
        first_difference(wanted, self.reference.list(step), self.model.triangles(cursor))
    }

    /// The hash of all triangles that are shown, listed anew.
    fn listed_hash(&self, cursor: &M::Cursor) -> TriangleHash {
        let mut hash = TriangleHash::default();
        self.model.for_each_triangle(cursor, |triangle| hash.add(triangle));
        hash
    }
}
