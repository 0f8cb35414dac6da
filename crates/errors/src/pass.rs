//! The pass over all steps. It keeps the largest distance found so far (*E* in comments; its square
//! is `max_squared`), and proposes the error of each step from it.
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
use crate::backward::Backward;
use crate::block::Block;
use crate::floor::Floor;
use crate::forward::Forward;
use crate::input::Input;
use crate::ladder::Proposals;
use crate::settings::Settings;
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
    /// Errors that are known before: no step proposes less.
    pub(crate) floor: Floor<'a>,
    pub(crate) settings: Settings,
    pub(crate) tick: &'a Tick<'a>,
}

impl Pass<'_> {
    /// Runs through all steps, or as many as the limit of work allows. Proposes no less than the
    /// floor. `corner_vertices` has the vertices of the input's triangles; after the numbers of
    /// steps in `planned`, which rise, it notes how far points are.
    pub(crate) fn run(self, corner_vertices: &[[u32; 3]], planned: &[usize]) -> Proposals {
        let Self { input, floor, settings, .. } = self;
        let sequence = self.simplified.collapses();
        let steps = sequence.steps_at(sequence.last_visible()) as u32;
        (self.tick)();
        let (mut forward, mut backward) = rayon::join(
            || Forward::new(input, corner_vertices, floor, settings),
            || Backward::new(input, settings.limits),
        );
        let mut proposals = Proposals::default();
        // The block that the forward pass follows, and the one before it.
        let (mut block, mut previous) = (Block::default(), Block::default());
        let mut steps_done = 0;
        loop {
            (self.tick)();
            let count = (steps_done.min(steps - steps_done) / BLOCK_DIVISOR)
                .clamp(MIN_BLOCK_STEPS, MAX_BLOCK_STEPS);
            let next = planned.iter().map(|&s| s as u32).find(|&planned| planned > steps_done);
            let range = steps_done..(steps_done + count).min(next.unwrap_or(steps)).min(steps);
            let block_steps = range.len();
            steps_done = range.end;
            let ((), followed) = rayon::join(
                || forward.run(sequence, range, &mut block),
                || backward.run(&previous),
            );
            for (step, max_squared) in previous.steps.iter().zip(followed.max_squared_at) {
                let is_distance = max_squared > ROUNDING_SQUARED;
                proposals.largest.push(if is_distance { max_squared.sqrt() as f32 } else { 0.0 });
                proposals.rms.push(step.mean_square.sqrt() as f32);
            }
            forward.learn(followed.max_squared, followed.work);
            if block.steps.len() == block_steps && next == Some(steps_done) {
                proposals.distances.push((steps_done as usize, forward.triangle_distances()));
            }
            if block.steps.is_empty() {
                return proposals;
            }
            std::mem::swap(&mut block, &mut previous);
        }
    }
}
