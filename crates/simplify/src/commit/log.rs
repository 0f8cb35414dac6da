//! The record of collapses, in the order in which they happen.

use std::ops::Range;

/// One collapse of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// The greatest cost of this collapse and all before it that touched the same groups.
    pub(crate) stamp: f32,
    /// In working units.
    pub(crate) error: f32,
    /// End of its records.
    records: u32,
    /// End of its dead triangles.
    removals: u32,
    pub(crate) changes_topology: bool,
}

/// Collapses in the order in which they happened.
#[derive(Default)]
pub(crate) struct CollapseLog {
    pub(crate) steps: Vec<Step>,
    /// Wedges that disappear.
    pub(crate) wedges: Vec<u32>,
    /// The wedge that each becomes.
    pub(crate) targets: Vec<u32>,
    /// Triangles that die.
    pub(crate) dead: Vec<u32>,
}

impl CollapseLog {
    /// A log with room for all steps of a mesh with so many groups, wedges and faces.
    pub(crate) fn with_room(groups: usize, wedges: usize, faces: usize) -> Self {
        Self {
            steps: Vec::with_capacity(groups),
            wedges: Vec::with_capacity(wedges),
            targets: Vec::with_capacity(wedges),
            dead: Vec::with_capacity(faces),
        }
    }

    /// Notes that a wedge becomes another in the present step.
    #[inline]
    pub(crate) fn record(&mut self, wedge: u32, target: u32) {
        self.wedges.push(wedge);
        self.targets.push(target);
    }

    /// Ends the present step.
    #[inline]
    pub(crate) fn end_step(&mut self, stamp: f32, error: f32, changes_topology: bool) {
        self.steps.push(Step {
            stamp,
            error,
            records: self.wedges.len() as u32,
            removals: self.dead.len() as u32,
            changes_topology,
        });
    }

    /// Appends the steps of another log.
    pub(crate) fn append(&mut self, other: &Self) {
        let (records, removals) = (self.wedges.len() as u32, self.dead.len() as u32);
        self.steps.extend(other.steps.iter().map(|s| Step {
            records: s.records + records,
            removals: s.removals + removals,
            ..*s
        }));
        self.wedges.extend_from_slice(&other.wedges);
        self.targets.extend_from_slice(&other.targets);
        self.dead.extend_from_slice(&other.dead);
    }

    /// The records of a step.
    pub(crate) fn records(&self, step: usize) -> Range<usize> {
        self.before(step, |s| s.records) as usize..self.steps[step].records as usize
    }

    /// The triangles that die in a step.
    pub(crate) fn removals(&self, step: usize) -> &[u32] {
        &self.dead[self.before(step, |s| s.removals) as usize..self.steps[step].removals as usize]
    }

    fn before(&self, step: usize, end: fn(&Step) -> u32) -> u32 {
        step.checked_sub(1).map_or(0, |before| end(&self.steps[before]))
    }
}
