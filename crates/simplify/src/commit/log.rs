//! The log of all collapses of a simplification, in their order, and the vertices from which every
//! wedge, fakes among them, has its position and attributes.

use crate::cut::Region;
use crate::number::Input;
use crate::recorded::RecordedCollapses;
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
    /// End of its triangles that die.
    removals: u32,
    pub(crate) changes_topology: bool,
}

/// Collapses in the order in which they happened.
#[derive(Default)]
pub(crate) struct CollapseLog {
    /// Those of a metric that sees.
    pub(crate) recorded: RecordedCollapses,
    pub(crate) steps: Vec<Step>,
    /// Wedges that disappear.
    pub(crate) wedges: Vec<u32>,
    /// The wedge that each becomes.
    pub(crate) targets: Vec<u32>,
    /// Triangles that die.
    pub(super) dead: Vec<u32>,
}

impl CollapseLog {
    /// An empty log with capacity for the whole simplification of a mesh, by its counts.
    pub(crate) fn with_room(groups: usize, wedges: usize, faces: usize) -> Self {
        Self {
            recorded: RecordedCollapses::default(),
            steps: Vec::with_capacity(groups),
            wedges: Vec::with_capacity(wedges),
            targets: Vec::with_capacity(wedges),
            dead: Vec::with_capacity(faces),
        }
    }

    /// Notes that a wedge becomes another in the present step.
    #[inline]
    pub(super) fn record(&mut self, wedge: u32, target: u32) {
        self.wedges.push(wedge);
        self.targets.push(target);
    }

    /// Ends the present step.
    #[inline]
    pub(super) fn end_step(&mut self, stamp: f32, error: f32, changes_topology: bool) {
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

/// The sources of the data of every wedge of the whole mesh.
pub(crate) struct Sources<'a> {
    input: &'a Input<'a>,
    /// The input vertices of the fakes' positions and attributes.
    fakes: Vec<(u32, u32)>,
}

impl<'a> Sources<'a> {
    pub(crate) fn new(input: &'a Input<'a>) -> Self {
        Self { input, fakes: Vec::new() }
    }

    /// Gives a region's new fakes their numbers, and its log those of the whole mesh.
    pub(crate) fn number(&mut self, region: &mut Region, log: &mut CollapseLog) {
        let first = (self.input.wedges() + self.fakes.len()) as u32;
        self.fakes.extend(region.wedges.number_fakes(first));
        name_wedges(region, log);
    }

    /// The vertex whose position and other spatial data a wedge has, and the one whose other
    /// attributes it has.
    pub(crate) fn of(&self, wedge: u32) -> (u32, u32) {
        match self.input.vertex_of().get(wedge as usize) {
            Some(&vertex) => (vertex, vertex),
            None => self.fakes[wedge as usize - self.input.wedges()],
        }
    }
}

/// Replaces a region's wedge numbers in its log by those of the whole mesh.
pub(crate) fn name_wedges(region: &Region, log: &mut CollapseLog) {
    for wedge in log.wedges.iter_mut().chain(&mut log.targets) {
        *wedge = region.wedge_id(*wedge);
    }
}
