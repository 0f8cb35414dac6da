//! Blocks of steps that the forward pass (from the input to the level) has followed: all that the
//! backward pass (from the level to the input) needs to know of them. `pass` runs both.

use crate::origin::Origin;
use crate::work::Work;

/// A face that a step touched, as it is after the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TouchedFace {
    pub(crate) face: u32,
    pub(crate) is_live: bool,
    /// Its corners, as points of the input.
    pub(crate) points: [u32; 3],
    /// Origin of the sample nearest to its centroid; [`Origin::NONE`] if it has no samples.
    pub(crate) origin: Origin,
}

impl TouchedFace {
    /// A face that became degenerate.
    pub(crate) fn dead(face: u32, points: [u32; 3]) -> Self {
        Self { face, is_live: false, points, origin: Origin::NONE }
    }
}

/// A step that the forward pass has followed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Ends of its ranges in [`Block::touched`] and [`Block::targets`].
    pub(crate) touched_end: u32,
    pub(crate) targets_end: u32,
    /// The point that moved, if exactly one did; [`lodc_mesh::NONE`] otherwise.
    pub(crate) source: u32,
    /// Number of live faces after the step.
    pub(crate) live_faces: u32,
    /// Square of the largest distance that the forward pass knew of after the step.
    pub(crate) max_squared: f64,
    /// Mean squared distance of all samples.
    pub(crate) mean_square: f64,
}

/// A step with the faces that it touched and the points that their corners moved to.
#[derive(Clone, Copy)]
pub(crate) struct StepView<'a> {
    pub(crate) step: Step,
    pub(crate) touched: &'a [TouchedFace],
    pub(crate) targets: &'a [u32],
}

/// Consecutive steps.
#[derive(Clone, Debug, Default)]
pub(crate) struct Block {
    pub(crate) steps: Vec<Step>,
    pub(crate) touched: Vec<TouchedFace>,
    pub(crate) targets: Vec<u32>,
    /// Work of the forward pass up to the end of the block.
    pub(crate) work: Work,
}

impl Block {
    pub(crate) fn clear(&mut self) {
        self.steps.clear();
        self.touched.clear();
        self.targets.clear();
    }

    /// Returns a step, by its index.
    pub(crate) fn view(&self, index: usize) -> StepView<'_> {
        let step = self.steps[index];
        let [touched_start, targets_start] = match index {
            0 => [0, 0],
            _ => [self.steps[index - 1].touched_end, self.steps[index - 1].targets_end],
        };
        StepView {
            step,
            touched: &self.touched[touched_start as usize..step.touched_end as usize],
            targets: &self.targets[targets_start as usize..step.targets_end as usize],
        }
    }

    pub(crate) fn views(&self) -> impl Iterator<Item = StepView<'_>> {
        (0..self.steps.len()).map(|index| self.view(index))
    }
}
