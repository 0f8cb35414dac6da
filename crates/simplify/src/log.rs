//! The record of collapses, in the order in which they happen, and the order in which they count.

use crate::numbering::sorted;
use lodc_mesh::Lod;

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
}

/// The collapses of a whole mesh in their final order.
#[derive(Default)]
pub(crate) struct FinalLog {
    /// Wedges in the order in which they disappear.
    pub(crate) order: Vec<u32>,
    /// The wedge that each becomes.
    pub(crate) targets: Vec<u32>,
    pub(crate) step_ends: Vec<u32>,
    /// In working units, never falling.
    pub(crate) step_errors: Vec<f32>,
    pub(crate) step_triangles: Vec<u32>,
    /// The LOD at which each input triangle dies.
    pub(crate) death: Vec<u32>,
    pub(crate) last_legal: Lod,
    pub(crate) topology_changes: u32,
    pub(crate) first_topology_change: Option<Lod>,
}

impl FinalLog {
    /// Puts a log in order: the first `legal` steps by stamp, equal ones as they happened; the
    /// others follow. A step's stamp is no less than those of the steps it builds on, so these stay
    /// before it.
    pub(crate) fn new(log: &CollapseLog, legal: usize, triangles: usize, sort: bool) -> Self {
        let mut result = Self { death: vec![0; triangles], ..Self::default() };
        result.order.reserve_exact(log.wedges.len() + 1);
        result.targets.reserve_exact(log.wedges.len());
        result.step_ends.reserve_exact(log.steps.len());
        result.step_errors.reserve_exact(log.steps.len());
        result.step_triangles.reserve_exact(log.steps.len());
        let keys: Vec<u64> =
            log.steps[..legal].iter().map(|s| u64::from(s.stamp.to_bits())).collect();
        let order = if sort { sorted(&keys, 32) } else { (0..legal as u32).collect() };
        let mut live = triangles as u32;
        for i in order.into_iter().chain(legal as u32..log.steps.len() as u32) {
            result.take(log, i as usize, i as usize >= legal, &mut live);
        }
        // The last wedge becomes nothing.
        result.order.extend(log.wedges.get(log.targets.len()..).into_iter().flatten());
        result
    }

    /// Appends a step.
    fn take(&mut self, log: &CollapseLog, i: usize, is_terminal: bool, live: &mut u32) {
        let (first_record, first_removal) = match i.checked_sub(1).map(|before| log.steps[before]) {
            Some(before) => (before.records as usize, before.removals as usize),
            None => (0, 0),
        };
        let step = log.steps[i];
        let records = first_record..step.records as usize;
        self.order.extend_from_slice(&log.wedges[records.clone()]);
        self.targets.extend_from_slice(&log.targets[records]);
        let lod = self.order.len() as u32;
        let dead = &log.dead[first_removal..step.removals as usize];
        for &triangle in dead {
            self.death[triangle as usize] = lod;
        }
        *live -= dead.len() as u32;
        let error = self.step_errors.last().copied().unwrap_or(0.0).max(step.error);
        self.step_ends.push(lod);
        self.step_errors.push(error);
        self.step_triangles.push(*live);
        if !is_terminal {
            self.last_legal = Lod(lod);
            if step.changes_topology {
                self.topology_changes += 1;
                self.first_topology_change.get_or_insert(Lod(lod));
            }
        }
    }
}
