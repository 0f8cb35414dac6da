//! View-dependent Interactive Meshes (thesis 5.3): a LOD for every wedge group, geomorphing, and a
//! degenerate filter.
//!
//! The surface cannot tear. All vertices of a wedge group choose by the same position and the same
//! cone of normals, so they get one LOD, rounded to the end of a step, and at the end of a step a
//! group is at one position. So a view is a map from positions to positions, applied to the
//! triangles of LOD 0, and such a map cannot make an edge that two triangles shared a border. The
//! same holds between steps, because what is interpolated, and how far, is the group's too.

mod cones;
mod criterion;
pub mod deterministic_math;
mod eye_space;
mod family;
mod filter;
mod passes;
mod replay;
mod select;
mod selector;
mod surface;
#[cfg(test)]
mod tests;

pub use cones::{Cone, Cones};
pub use criterion::{Criterion, ViewQuery};
pub use family::{Family, LodRange, finest_within};
pub use filter::{Filter, Filtered, filtered};
pub use passes::ViewPasses;
pub use replay::sample;
pub use select::{Point, State};
pub use selector::Selector;
pub use surface::{drawn_triangles, live_triangles, morphed_mesh, view_mesh};

use lodc_mesh::{Lod, Simplified};
use lodc_plan::VertexRecords;
use lodc_verify::{Failure, ShownView, ViewReference};

/// The view-dependent variant: the CPU version of the kernels.
#[derive(Clone, Debug)]
pub struct Views<'a> {
    selector: Selector<'a>,
    records: VertexRecords,
}

/// The content of one view.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewContent {
    /// The state of each vertex.
    pub states: Vec<State>,
    /// The words of the records that are drawn, a record for each vertex.
    pub vertices: Vec<u32>,
}

impl ViewContent {
    /// Returns the first thing that is wrong with what is shown, `indices` being the triangles that
    /// are drawn and `stride` the words of a record.
    #[must_use]
    pub fn check(
        &self,
        reference: &ViewReference<'_>,
        view: &ViewQuery,
        indices: &[u32],
        stride: usize,
    ) -> Option<Failure> {
        let lods: Vec<Lod> = self.states.iter().map(|state| Lod(state.lod)).collect();
        let vertices: Vec<u32> = self.states.iter().map(|state| state.entry).collect();
        let position = |record: &[u32]| [record[0], record[1], record[2]].map(f32::from_bits);
        let positions: Vec<[f32; 3]> = self.vertices.chunks_exact(stride).map(position).collect();
        let shown = ShownView {
            lods: &lods,
            vertices: &vertices,
            positions: &positions,
            indices,
            morphs: view.morph,
        };
        reference.first_failure(&shown)
    }
}

impl<'a> Views<'a> {
    /// Finds groups and cones.
    #[must_use]
    pub fn new(simplified: &'a Simplified, records: VertexRecords) -> Self {
        Self { selector: Selector::new(simplified), records }
    }

    /// Returns the input of each vertex's selection.
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.selector.points
    }

    /// Returns the target of each vertex and the LOD from which on the target is shown in its
    /// place; of the last vertex itself and [`NONE`](lodc_mesh::NONE).
    #[must_use]
    pub fn links(&self) -> &[[u32; 2]] {
        &self.selector.links
    }

    /// The coarsest LOD for errors in rising order, and the upper 18 bits of the first one.
    #[must_use]
    pub fn by_error(&self) -> (&[u32], u32) {
        (&self.selector.by_error.lods, self.selector.by_error.lowest)
    }

    /// Returns the vertices of a view.
    #[must_use]
    pub fn show(&self, view: &ViewQuery) -> ViewContent {
        let states = self.selector.states(&self.selector.lods(&view.criterion), view.morph);
        let mut vertices = Vec::with_capacity(self.records.words.len());
        let position = |v: u32| {
            let record = self.records.at(v);
            [record[0], record[1], record[2]].map(f32::from_bits)
        };
        for &State { entry, lod, progress, .. } in &states {
            let first = vertices.len();
            vertices.extend_from_slice(self.records.at(entry));
            if progress != 0 {
                let morphed = select::morphed_position(entry, lod, &self.selector.links, position);
                vertices[first..first + 3].copy_from_slice(&morphed.map(f32::to_bits));
            }
        }
        ViewContent { states, vertices }
    }
}
