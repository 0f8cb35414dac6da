//! The pass over all steps: an error that never falls, raised where a sample or a new face is
//! farther.
//!
//! ```text
//!   forward    | block 1 | block 2 | block 3 | block 4 | ...
//!   backward             | block 1 | block 2 ...  ╱ learns of block 1
//! ```
//!
//! Both ways run at once, up to some blocks of steps apart, and the first one always learns of a
//! block the same number of blocks later: so nothing depends on their speed.

use crate::Tick;
use crate::backward::{Backward, Followed};
use crate::block::Block;
use crate::floor::{Floor, MARGIN};
use crate::follower::{Follower, Here, beside};
use crate::forward::Forward;
use crate::input::Input;
use crate::step_errors::StepErrors;
use crate::thresholds::Thresholds;
use crate::work::FLOOR;
use lodc_mesh::Simplified;

/// Steps of a block: a share of the steps done and of those to come, for the bound grows fast at
/// both ends. The bounds keep blocks worth handing over, and short enough that the backward pass is
/// never far behind. Chosen by hand.
const SHARE: u32 = 16;
const FEWEST: u32 = 32;
const MOST: u32 = 2_048;

/// Blocks that the forward pass is ahead: it learns what the other found in a block when it has
/// followed this many more. Fewer, and threads wait for each other; more, and the bound comes late.
const AHEAD: usize = 3;

/// Meshes of fewer steps are followed on one thread: starting another takes as long.
const FEW_STEPS: u32 = 1_000;

/// Runs through all steps, or as many as can be followed in time. States no less than the floor.
pub(crate) fn run(
    input: &Input,
    wedges: Vec<[u32; 3]>,
    simplified: &Simplified,
    (floor, thresholds): (Floor<'_>, Thresholds),
    tick: &Tick<'_>,
) -> StepErrors {
    tick();
    let (forward, backward) = rayon::join(
        || Forward::new(input, wedges, (floor, thresholds)),
        || Backward::new(input, thresholds),
    );
    let steps = simplified.collapses().steps() as u32;
    let stated = Stated::new(input, steps, forward.at_points(), floor);
    if rayon::current_num_threads() < thresholds.threads || steps < FEW_STEPS {
        return follow(forward, stated, simplified, Here::new(backward), tick);
    }
    std::thread::scope(|scope| {
        let other = beside(scope, backward);
        follow(forward, stated, simplified, other, tick)
    })
}

/// Follows all steps, in blocks, of which the backward pass gets each.
fn follow(
    mut forward: Forward,
    mut stated: Stated,
    simplified: &Simplified,
    mut other: impl Follower,
    tick: &Tick<'_>,
) -> StepErrors {
    let sequence = simplified.collapses();
    let steps = sequence.steps() as u32;
    let (mut under_way, mut done) = (0, 0);
    loop {
        tick();
        let mut block = Block::default();
        if under_way == AHEAD {
            let Some(followed) = other.receive() else { break };
            stated.push(&followed);
            forward.learn(followed.bound, followed.work);
            block = followed.block;
            under_way -= 1;
        }
        let count = (done.min(steps - done) / SHARE).clamp(FEWEST, MOST);
        let range = done..(done + count).min(steps);
        forward.run(sequence, range.clone(), &mut block);
        if block.steps.is_empty() {
            break;
        }
        done = range.end;
        other.send(block);
        under_way += 1;
    }
    for _ in 0..under_way {
        other.receive().iter().for_each(|followed| stated.push(followed));
    }
    stated.errors
}

/// Errors of the steps that both ways have followed.
struct Stated<'a> {
    input: &'a Input,
    errors: StepErrors,
    rms: f64,
    /// Steps that moved a point.
    gone: u32,
    /// Share of the area that belongs to samples at points.
    at_points: f64,
    floor: Floor<'a>,
}

impl<'a> Stated<'a> {
    fn new(input: &'a Input, steps: u32, at_points: f64, floor: Floor<'a>) -> Self {
        let errors = StepErrors::with_capacity(steps as usize);
        Self { input, errors, rms: 0.0, gone: 0, at_points, floor }
    }

    /// Adds the steps of a block, as far as both ways have followed them.
    fn push(&mut self, Followed { block, found, .. }: &Followed) {
        for ((step, entries, _), found) in block.each().zip(found) {
            self.gone += u32::from(!entries.is_empty());
            if self.input.triangles.is_empty() {
                self.errors.push(0.0, 0.0);
                continue;
            } else if step.live == 0 {
                self.errors.push(f64::INFINITY, f64::INFINITY);
                continue;
            }
            self.rms = self.rms.max(self.rms(step.mean_square.max(found.mean_square)));
            let (step, unit) = (self.errors.error.len(), self.input.unit);
            let raised = found.bound > self.floor.squared(step).max(FLOOR);
            let error = if raised { found.bound.sqrt() * MARGIN * unit } else { 0.0 };
            let error = error.max(self.floor.stated(step));
            self.errors.push(error, (self.rms * unit).min(error));
        }
    }

    /// Returns the root mean square distance for the mean squared distance of samples.
    fn rms(&self, mean_square: f64) -> f64 {
        // Between a point that is off and one that is not, the distance falls to 0: the integral
        // of a piecewise linear function is smaller than its lumped sum by (1 + share gone) / 2.
        // The area that belongs to samples inside of triangles is not lumped.
        let share = f64::from(self.gone) / self.input.places.len() as f64;
        let lumped = (0.5 + 0.5 * share).min(1.0);
        ((1.0 - self.at_points * (1.0 - lumped)) * mean_square).sqrt()
    }
}
