//! Steps that one way has followed and the other has not: all that the other needs of them.

use crate::work::Work;
use lodc_mesh::NONE;

/// A face that a step touched, as it is after the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) face: u32,
    pub(crate) is_live: bool,
    /// Its corners, as points.
    pub(crate) points: [u32; 3],
    /// The mean squared distance of its samples; not a number if they do not tell it.
    pub(crate) mean_square: f32,
    /// The origin of the sample that is nearest to its middle; [`NONE`] if it has none.
    pub(crate) hint: u32,
}

impl Entry {
    /// A face that is gone.
    pub(crate) fn dead(face: u32, points: [u32; 3]) -> Self {
        Self { face, is_live: false, points, mean_square: f32::NAN, hint: NONE }
    }
}

/// A step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Ends of its entries and of its targets.
    pub(crate) entries_end: u32,
    pub(crate) targets_end: u32,
    /// The point that moved, if it was one; [`NONE`] otherwise.
    pub(crate) source: u32,
    /// Faces that are left.
    pub(crate) live: u32,
    /// The squared bound that the forward pass has found.
    pub(crate) bound: f64,
    /// The mean squared distance of the samples.
    pub(crate) mean_square: f64,
}

/// Some steps in a row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Block {
    pub(crate) steps: Vec<Step>,
    pub(crate) entries: Vec<Entry>,
    /// The points that corners move to.
    pub(crate) targets: Vec<u32>,
    /// Work of the forward pass at the end.
    pub(crate) work: Work,
    /// True if the forward pass gave up after these steps.
    pub(crate) gave_up: bool,
}

impl Block {
    /// Empties the block.
    pub(crate) fn clear(&mut self) {
        self.steps.clear();
        self.entries.clear();
        self.targets.clear();
        self.gave_up = false;
    }

    /// Returns each step with its entries and its targets.
    pub(crate) fn each(&self) -> impl Iterator<Item = (Step, &[Entry], &[u32])> {
        let mut starts = [0, 0];
        self.steps.iter().map(move |&step| {
            let ends = [step.entries_end as usize, step.targets_end as usize];
            let [entries, targets] = std::mem::replace(&mut starts, ends);
            (step, &self.entries[entries..ends[0]], &self.targets[targets..ends[1]])
        })
    }
}
