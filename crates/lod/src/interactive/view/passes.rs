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
    step_ends: BufferId,
    step_errors: BufferId,
    /// Three words per group: see [`State`].
    pub states: BufferId,
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
        let words = |g: &Group| {
            let [x, y, z] = g.axis.map(f32::to_bits);
            [x, y, z, g.cos.to_bits(), g.sin.to_bits(), g.first_vertex]
        };
        let groups: Vec<u32> = views.groups.iter().flat_map(words).collect();
        Self {
            groups: program.words("groups", groups),
            group_of: program.words("group_of", views.group_of.as_slice()),
            step_ends: program.words("step_ends", parts.step_ends.as_slice()),
            step_errors: program.words("step_errors", errors),
            states: program.zeros("states", 3 * views.groups.len()),
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
        let mut parameters =
            vec![groups, steps, records, stride, p.criterion, u32::from(p.morph), p.lods[0], p.lods[1]];
        parameters.extend(p.point.map(f32::to_bits));
        parameters.push(p.scale.to_bits());
        parameters.extend(p.abc.map(f32::to_bits));
        parameters.push(0);
        let base = &self.base;
        let select = Pass {
            kernel: self.select,
            buffers: vec![
                self.groups,
                base.source,
                self.step_ends,
                self.step_errors,
                base.offsets,
                base.entries,
                self.states,
            ],
            threads: groups,
            parameters,
        };
        let extract = Pass {
            kernel: self.extract,
            buffers: vec![self.group_of, self.states, base.offsets, base.entries, base.source, base.vertices],
            threads: vertices,
            parameters: vec![vertices, stride, 0],
        };
        vec![select, extract]
    }
}

/// States as the device holds them.
pub(super) fn words(states: &[State]) -> Vec<u32> {
    states.iter().flat_map(|s| [s.shown, s.towards, s.way]).collect()
}
