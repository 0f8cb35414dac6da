//! The pass over all steps. It keeps the largest distance found so far (*E* in comments; its square
//! is `max_squared`), and states the error of each step from it.
//!
//! ```text
//!   forward    | block 1 | block 2 | block 3 | block 4 | ...    block 3 knows what the backward
//!   backward             | block 1 | block 2 | block 3 | ...    pass has found in block 1
//! ```
//!
//! The forward pass measures from the input to the level, the backward pass from the level to the
//! input, one block of steps later and at the same time; it follows the components of a block in
//! parallel. What either knows follows from the blocks alone: so nothing depends on the threads.

use crate::Tick;
use crate::backward::{Backward, FollowedBlock};
use crate::block::Block;
use crate::floor::{Floor, MARGIN};
use crate::forward::Forward;
use crate::input::Input;
use crate::settings::Settings;
use crate::step_errors::StepErrors;
use crate::work::ROUNDING_SQUARED;
use lodc_mesh::Simplified;

/// A block has the steps done, or those to come if they are fewer, divided by this: E grows fast at
/// both ends, and the passes hear of it a block or two late. Between two bounds, which keep blocks
/// worth sharing out, and their memory small. Chosen by hand.
const BLOCK_DIVISOR: u32 = 32;
const MIN_BLOCK_STEPS: u32 = 32;
const MAX_BLOCK_STEPS: u32 = 2_048;

/// What a pass works on.
#[derive(Clone, Copy)]
pub(crate) struct Pass<'a> {
    pub(crate) input: &'a Input,
    pub(crate) simplified: &'a Simplified,
    /// Errors that are known before: no step states less.
    pub(crate) floor: Floor<'a>,
    pub(crate) settings: Settings,
    pub(crate) tick: &'a Tick<'a>,
}

impl Pass<'_> {
    /// Runs through all steps, or as many as the limit of work allows. States no less than the
    /// floor. `corner_vertices` has the vertices of the input's triangles.
    pub(crate) fn run(self, corner_vertices: Vec<[u32; 3]>) -> StepErrors {
        let Self { input, floor, settings, .. } = self;
        let (sequence, steps) = (self.simplified.collapses(), self.steps());
        (self.tick)();
        let (mut forward, mut backward) = rayon::join(
            || Forward::new(input, corner_vertices, floor, settings),
            || Backward::new(input, settings),
        );
        let mut stated = StatedErrors::new(&self, forward.point_area_share());
        // The block that the forward pass follows, and the one before it.
        let (mut block, mut previous) = (Block::default(), Block::default());
        let mut steps_done = 0;
        loop {
            (self.tick)();
            let count = (steps_done.min(steps - steps_done) / BLOCK_DIVISOR)
                .clamp(MIN_BLOCK_STEPS, MAX_BLOCK_STEPS);
            let range = steps_done..(steps_done + count).min(steps);
            steps_done = range.end;
            let ((), followed) = rayon::join(
                || forward.run(sequence, range, &mut block),
                || backward.run(&previous),
            );
            stated.push(&previous, &followed);
            forward.learn(followed.max_squared, followed.work);
            if block.steps.is_empty() {
                return stated.errors;
            }
            std::mem::swap(&mut block, &mut previous);
        }
    }

    fn steps(&self) -> u32 {
        self.simplified.collapses().steps() as u32
    }
}

/// Errors of the steps that both passes have followed.
struct StatedErrors<'a> {
    input: &'a Input,
    floor: Floor<'a>,
    errors: StepErrors,
    /// The largest root mean square distance so far, in units of the input.
    max_rms: f64,
    /// Steps that moved a point.
    moving_steps: u32,
    /// Share of the area that belongs to samples at points.
    point_area_share: f64,
}

impl<'a> StatedErrors<'a> {
    fn new(pass: &Pass<'a>, point_area_share: f64) -> Self {
        let errors = StepErrors::with_capacity(pass.steps() as usize);
        let (input, floor) = (pass.input, pass.floor);
        Self { input, floor, errors, max_rms: 0.0, moving_steps: 0, point_area_share }
    }

    /// Adds the steps of a block, as far as both passes have followed them.
    fn push(&mut self, block: &Block, followed: &FollowedBlock) {
        for (view, distances) in block.views().zip(&followed.distances) {
            self.moving_steps += u32::from(!view.touched.is_empty());
            if self.input.triangles.is_empty() {
                self.errors.push(0.0, 0.0);
                continue;
            } else if view.step.live_faces == 0 {
                self.errors.push(f64::INFINITY, f64::INFINITY);
                continue;
            }
            let mean_square = view.step.mean_square.max(distances.mean_square);
            self.max_rms = self.max_rms.max(self.rms(mean_square));
            let (step, scale) = (self.errors.error.len(), self.input.mesh_scale);
            let max_squared = distances.max_squared;
            let is_raised = max_squared > self.floor.squared(step).max(ROUNDING_SQUARED);
            let error = if is_raised { max_squared.sqrt() * MARGIN * scale } else { 0.0 };
            let error = error.max(self.floor.stated(step));
            self.errors.push(error, (self.max_rms * scale).min(error));
        }
    }

    /// Returns the root mean square distance for the mean squared distance of samples.
    fn rms(&self, mean_square: f64) -> f64 {
        // Between a point that has moved and one that has not, the distance falls to 0: the
        // integral of a piecewise linear function is smaller than its lumped sum by
        // (1 + share moved) / 2. The area of samples inside of triangles is not lumped.
        let moved_share = f64::from(self.moving_steps) / self.input.coordinates.len() as f64;
        let lumped = (0.5 + 0.5 * moved_share).min(1.0);
        ((1.0 - self.point_area_share * (1.0 - lumped)) * mean_square).sqrt()
    }
}
