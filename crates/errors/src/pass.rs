//! The pass over all steps. It keeps the largest distance found so far (*E* in comments; its square
//! is `max_squared`), and states the error of each step from it.
//!
//! ```text
//!   forward    | block 1 | block 2 | block 3 | block 4 | ...    block 4 knows what the backward
//!   backward             | block 1 | block 2 | ...               pass has found in block 1
//! ```
//!
//! The forward pass measures from the input to the level, the backward pass from the level to the
//! input. Both run at once, some blocks of steps apart, and the forward pass always learns of a
//! block the same number of blocks later: so nothing depends on their speed.

use crate::Tick;
use crate::backward::{Backward, FollowedBlock};
use crate::block::Block;
use crate::floor::{Floor, MARGIN};
use crate::forward::Forward;
use crate::input::Input;
use crate::runner::{InlineRunner, Runner, ThreadRunner};
use crate::settings::Settings;
use crate::step_errors::StepErrors;
use crate::work::ROUNDING_SQUARED;
use lodc_mesh::Simplified;

/// A block has the steps done, or those to come if they are fewer, divided by this: E grows fast at
/// both ends. Between two bounds, which keep blocks worth handing over, and short enough that the
/// backward pass is never far behind. Chosen by hand.
const BLOCK_DIVISOR: u32 = 16;
const MIN_BLOCK_STEPS: u32 = 32;
const MAX_BLOCK_STEPS: u32 = 2_048;

/// Blocks that the forward pass is ahead of the backward pass. With fewer, threads wait for each
/// other; with more, the forward pass hears of a larger E late. Chosen by hand.
const BLOCKS_AHEAD: usize = 3;

/// Meshes of fewer steps are followed on one thread: starting another takes as long.
const MIN_STEPS_FOR_THREAD: u32 = 1_000;

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
        (self.tick)();
        let (forward, backward) = rayon::join(
            || Forward::new(input, corner_vertices, floor, settings),
            || Backward::new(input, settings),
        );
        let threads = rayon::current_num_threads();
        if threads < settings.min_threads || self.steps() < MIN_STEPS_FOR_THREAD {
            return self.follow(forward, InlineRunner::new(backward));
        }
        std::thread::scope(|scope| self.follow(forward, ThreadRunner::spawn(scope, backward)))
    }

    fn steps(&self) -> u32 {
        self.simplified.collapses().steps() as u32
    }

    /// Follows all steps block by block.
    fn follow(&self, mut forward: Forward, mut backward: impl Runner) -> StepErrors {
        let (sequence, steps) = (self.simplified.collapses(), self.steps());
        let mut stated = StatedErrors::new(self, forward.point_area_share());
        let (mut blocks_under_way, mut steps_done) = (0, 0);
        loop {
            (self.tick)();
            let mut block = Block::default();
            if blocks_under_way == BLOCKS_AHEAD {
                let Some(followed) = backward.receive() else { break };
                stated.push(&followed);
                forward.learn(followed.max_squared, followed.work);
                block = followed.block;
                blocks_under_way -= 1;
            }
            let count = (steps_done.min(steps - steps_done) / BLOCK_DIVISOR)
                .clamp(MIN_BLOCK_STEPS, MAX_BLOCK_STEPS);
            let range = steps_done..(steps_done + count).min(steps);
            forward.run(sequence, range.clone(), &mut block);
            if block.steps.is_empty() {
                break;
            }
            steps_done = range.end;
            backward.send(block);
            blocks_under_way += 1;
        }
        for _ in 0..blocks_under_way {
            backward.receive().iter().for_each(|followed| stated.push(followed));
        }
        stated.errors
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
    fn push(&mut self, FollowedBlock { block, distances, .. }: &FollowedBlock) {
        for (view, distances) in block.views().zip(distances) {
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
