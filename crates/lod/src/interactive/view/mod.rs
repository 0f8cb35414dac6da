//! View-dependent Interactive Meshes (thesis 5.3): a LOD for every wedge group, geomorphing, and a degenerate filter.
//!
//! The surface cannot tear. All vertices of a wedge group get one LOD, which is the end of a step, and at the end of a
//! step a group is at one position. So a view is a map from positions to positions, applied to the triangles of LOD 0,
//! and such a map cannot make an edge that two triangles shared a border. The same holds between steps, because what
//! is interpolated, and how far, is the group's too.

mod cones;
mod criterion;
pub mod exact;
mod filter;
mod judge;
mod passes;
mod replay;
mod select;
#[cfg(test)]
mod tests;

pub use cones::{Cone, Cones};
pub use criterion::{Criterion, View};
pub use filter::{Filter, filtered};
pub use passes::ViewPasses;
pub use replay::sample;
pub use select::{Group, State};

use super::CollapseLists;
use crate::plan::VertexRecords;
use exact::lerp;
use lodc_mesh::{PositionIds, Simplified};
use select::Parameters;

/// The view-dependent variant on the CPU: the twin of the kernels.
#[derive(Clone, Debug)]
pub struct Views<'a> {
    simplified: &'a Simplified,
    lists: CollapseLists,
    records: VertexRecords,
    /// The group of each vertex; `u32::MAX` for fake vertices.
    group_of: Vec<u32>,
    groups: Vec<Group>,
}

/// What one view shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// The state of each group.
    pub states: Vec<State>,
    /// Which vertex each vertex shows, before it is moved towards the next one.
    pub entries: Vec<u32>,
    /// The records that are drawn.
    pub vertices: Vec<u32>,
}

impl<'a> Views<'a> {
    /// Finds groups and cones.
    #[must_use]
    pub fn new(simplified: &'a Simplified, lists: CollapseLists, records: VertexRecords) -> Self {
        let mesh = simplified.mesh();
        let cones = Cones::new(mesh, &PositionIds::new(mesh.positions()), simplified.collapses());
        let groups = select::groups(&cones, mesh);
        Self { simplified, lists, records, group_of: cones.of_vertex, groups }
    }

    /// The groups.
    #[must_use]
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// What a view shows.
    #[must_use]
    pub fn show(&self, view: &View) -> Shown {
        let parameters = Parameters::new(view, self.simplified);
        let (mesh, collapses) = (self.simplified.mesh(), self.simplified.collapses());
        let state = |group: &Group| select::state(&parameters, group, collapses, &self.lists);
        let states: Vec<State> = self.groups.iter().map(state).collect();
        let mut entries: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
        let mut vertices = self.records.words.clone();
        for (v, &group) in self.group_of.iter().enumerate() {
            // Vertices that no triangle of LOD 0 uses are never drawn as themselves.
            let Some(&State { shown, towards, way }) = states.get(group as usize) else { continue };
            let list = self.lists.list(v as u32);
            let entry = |lod: u32| list[list.partition_point(|&e| e < lod).min(list.len() - 1)];
            entries[v] = entry(shown);
            let record = &mut vertices[v * self.records.stride..][..self.records.stride];
            record.copy_from_slice(self.records.at(entries[v]));
            if way != 0 {
                let next = self.records.at(entry(towards));
                let t = way as f32 * (1.0 / 65536.0);
                for (word, &b) in record[..3].iter_mut().zip(next) {
                    *word = lerp(f32::from_bits(*word), f32::from_bits(b), t).to_bits();
                }
            }
        }
        Shown { states, entries, vertices }
    }
}
