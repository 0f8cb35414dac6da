//! The log of all collapses of a simplification, in their order, and the vertices from which every
//! wedge, fakes among them, has its position and attributes.

use crate::cut::{FakeSource, Region};
use crate::number::Input;
use crate::recorded::RecordedCollapses;
use std::ops::Range;

/// One collapse of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// The greatest cost of this collapse and all before it that touched the same groups: sorted by
    /// stamp, no step comes before one that it builds on.
    pub(crate) stamp: f32,
    /// In units of the scaled mesh that the simplifier works on.
    pub(crate) error: f32,
    /// End of its records in [`CollapseLog::wedges`]; they begin at the end of the step before.
    record_end: u32,
    /// End of the triangles that it removes, in [`CollapseLog::dead`].
    removal_end: u32,
    pub(crate) changes_topology: bool,
}

/// Collapses in the order in which they happened.
#[derive(Default)]
pub(crate) struct CollapseLog {
    /// The collapses for another run by `hybrid` to begin with, as a build makes it where pictures
    /// of this one's levels look worse. Empty for the quadric, which alone has rounds of several
    /// regions: `append` has none to join.
    pub(crate) recorded: RecordedCollapses,
    pub(crate) steps: Vec<Step>,
    /// The wedge that disappears with each record.
    pub(crate) wedges: Vec<u32>,
    /// The wedge that each becomes.
    pub(crate) targets: Vec<u32>,
    /// Triangles that are removed, step by step.
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
            record_end: self.wedges.len() as u32,
            removal_end: self.dead.len() as u32,
            changes_topology,
        });
    }

    /// Appends the steps of another log.
    pub(crate) fn append(&mut self, other: &Self) {
        let (records, removals) = (self.wedges.len() as u32, self.dead.len() as u32);
        self.steps.extend(other.steps.iter().map(|s| Step {
            record_end: s.record_end + records,
            removal_end: s.removal_end + removals,
            ..*s
        }));
        self.wedges.extend_from_slice(&other.wedges);
        self.targets.extend_from_slice(&other.targets);
        self.dead.extend_from_slice(&other.dead);
    }

    /// The records of a step.
    pub(crate) fn records(&self, step: usize) -> Range<usize> {
        self.before(step, |s| s.record_end) as usize..self.steps[step].record_end as usize
    }

    /// The triangles that are removed in a step.
    pub(crate) fn removals(&self, step: usize) -> &[u32] {
        &self.dead
            [self.before(step, |s| s.removal_end) as usize..self.steps[step].removal_end as usize]
    }

    /// The end of the step before; 0 for the first.
    fn before(&self, step: usize, end: fn(&Step) -> u32) -> u32 {
        step.checked_sub(1).map_or(0, |before| end(&self.steps[before]))
    }
}

/// The sources of the data of every wedge of the whole mesh.
pub(crate) struct Sources<'a> {
    input: &'a Input<'a>,
    fakes: Vec<FakeSource>,
}

impl<'a> Sources<'a> {
    pub(crate) fn new(input: &'a Input<'a>) -> Self {
        Self { input, fakes: Vec::new() }
    }

    /// Gives a region's new fakes their numbers, and its log those of the whole mesh.
    pub(crate) fn number_fakes(&mut self, region: &mut Region, log: &mut CollapseLog) {
        let first = (self.input.wedges() + self.fakes.len()) as u32;
        self.fakes.extend(region.wedges.number_fakes(first));
        renumber_wedges(region, log);
    }

    /// The vertex whose position and other spatial data a wedge has, the one whose other
    /// attributes it has, and its submesh.
    pub(crate) fn of(&self, wedge: u32) -> FakeSource {
        match self.input.vertex_of().get(wedge as usize) {
            Some(&vertex) => FakeSource {
                position: vertex,
                attributes: vertex,
                submesh: self.input.mesh.vertex_submesh()[vertex as usize],
            },
            None => self.fakes[wedge as usize - self.input.wedges()],
        }
    }
}

/// Replaces a region's wedge numbers in its log by those of the whole mesh.
pub(crate) fn renumber_wedges(region: &Region, log: &mut CollapseLog) {
    for wedge in log.wedges.iter_mut().chain(&mut log.targets) {
        *wedge = region.wedge_id(*wedge);
    }
}
