//! The view-dependent variant on a device: selection and extraction.

use super::select::{Parameters, State};
use super::{Group, View, Views};
use crate::interactive::{Continuous, shaders};
use crate::plan::{BufferId, KernelId, Pass, Program};

/// Buffers and kernels of the view-dependent variant, beside those of the continuous one.
#[derive(Clone, Debug)]
pub struct ViewPasses {
    groups: BufferId,
    group_of: BufferId,
    step_of: BufferId,
    step_ends: BufferId,
    step_errors: BufferId,
    /// The LOD that each group shows.
    pub shown: BufferId,
    /// The LOD that each group moves towards, and how far it is on the way; only with morphing.
    pub ways: BufferId,
    base: Continuous,
    select: KernelId,
    extract: KernelId,
    sizes: [u32; 5],
}

impl ViewPasses {
    /// Makes room for what the continuous variant does not have.
    pub fn new(program: &mut Program, views: &Views<'_>, base: &Continuous) -> Self {
        let parts = views.simplified.collapses().parts();
        let errors: Vec<u32> = parts.step_errors.iter().map(|e| e.to_bits()).collect();
        let groups: Vec<u32> = views.groups.iter().flat_map(Group::words).collect();
        let mut step_of = Vec::with_capacity(2 * parts.targets.len());
        let mut start = 0;
        for &end in &parts.step_ends {
            step_of.extend((start..end).flat_map(|_| [start, end]));
            start = end;
        }
        Self {
            groups: program.words("groups", groups),
            group_of: program.words("group_of", views.group_of.as_slice()),
            step_of: program.words("step_of", step_of),
            step_ends: program.words("step_ends", parts.step_ends.as_slice()),
            step_errors: program.words("step_errors", errors),
            shown: program.zeros("shown", views.groups.len()),
            ways: program.zeros("ways", 2 * views.groups.len()),
            base: base.clone(),
            select: program.kernel(shaders::SELECT),
            extract: program.kernel(shaders::VIEW),
            sizes: [
                views.groups.len() as u32,
                parts.step_ends.len() as u32,
                views.simplified.collapses().records(),
                views.records.stride as u32,
                views.simplified.mesh().vertex_count() as u32,
            ],
        }
    }

    /// Chooses a LOD for every group, then shows it.
    #[must_use]
    pub fn passes(&self, view: &View, views: &Views<'_>) -> Vec<Pass> {
        let [groups, steps, records, stride, vertices] = self.sizes;
        let p = Parameters::new(view, views.simplified);
        let mut parameters = vec![groups, steps, records, p.criterion, u32::from(p.morph), p.lods[0], p.lods[1]];
        parameters.extend(p.point.map(f32::to_bits));
        parameters.push(p.scale.to_bits());
        parameters.extend(p.abc.map(f32::to_bits));
        parameters.push(0);
        let base = &self.base;
        let select = Pass {
            kernel: self.select,
            buffers: vec![
                self.groups,
                self.step_of,
                self.step_ends,
                self.step_errors,
                base.offsets,
                base.entries,
                self.shown,
                self.ways,
            ],
            threads: groups,
            parameters,
        };
        let extract = Pass {
            kernel: self.extract,
            buffers: vec![self.group_of, self.shown, self.ways, base.offsets, base.entries, base.source, base.vertices],
            threads: vertices,
            parameters: vec![vertices, stride, u32::from(view.morph), 0],
        };
        vec![select, extract]
    }
}

/// States as the device holds them: what is shown, and the ways.
pub(super) fn words(states: &[State]) -> [Vec<u32>; 2] {
    [states.iter().map(|s| s.shown).collect(), states.iter().flat_map(|s| [s.towards, s.way]).collect()]
}
