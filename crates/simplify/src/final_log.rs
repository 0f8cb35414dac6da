//! The order in which collapses count.

use crate::commit::log::CollapseLog;
use crate::number::curve::sorted;
use crate::number::input::Input;
use lodc_mesh::Lod;

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
    pub(crate) fn new(log: &CollapseLog, legal: usize, input: &Input<'_>, sort: bool) -> Self {
        let triangles = input.mesh.triangles().len();
        let mut result = Self { death: vec![0; triangles], ..Self::default() };
        result.order.reserve_exact(log.wedges.len() + 1);
        result.targets.reserve_exact(log.wedges.len());
        result.step_ends.reserve_exact(log.steps.len());
        result.step_errors.reserve_exact(log.steps.len());
        result.step_triangles.reserve_exact(log.steps.len());
        let keys: Vec<u64> =
            log.steps[..legal].iter().map(|s| u64::from(s.stamp.to_bits())).collect();
        let mut order = if sort { sorted(&keys, 32) } else { (0..legal as u32).collect() };
        order.extend(legal as u32..log.steps.len() as u32);
        let mut live = triangles as u32;
        for i in order {
            result.take(log, i as usize, i as usize >= legal, &mut live);
        }
        // The last wedge becomes nothing.
        result.order.extend(log.wedges.get(log.targets.len()..).into_iter().flatten());
        result
    }

    /// Appends a step.
    fn take(&mut self, log: &CollapseLog, i: usize, is_terminal: bool, live: &mut u32) {
        let (step, records) = (log.steps[i], log.records(i));
        self.order.extend_from_slice(&log.wedges[records.clone()]);
        self.targets.extend_from_slice(&log.targets[records]);
        let lod = self.order.len() as u32;
        let dead = log.removals(i);
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
