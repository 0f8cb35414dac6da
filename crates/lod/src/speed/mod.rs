//! Speed Strips (thesis chapter 3): static strips and one list of changes.
//!
//! Every record changes indices of some strips. What then draws only degenerate triangles (indices
//! that repeat the one or the second one before them, dead ends) is taken out by *removals*, so
//! that strips get shorter as the mesh gets coarser. The list is walked in both directions; files
//! store strips and removals, the rest follows. See [`RunTime`] for the arrays and [`Cursor`] for
//! the extraction.

mod apply;
mod cursor;
mod edits;
mod measure;
mod replay;
mod run_time;
mod stored;
#[cfg(test)]
mod tests;

pub use crate::trace::{Removal, RemovalKind};
pub use cursor::Cursor;
pub use replay::SHADERS;
pub use run_time::{AT_END, LodInfo, Operation, RunTime, StripInfo};

use crate::cut::{LONGEST_TRACED, cut_long};
use crate::stored_strips::{self, STRIPS, check_submeshes};
use crate::trace::{self, History, TraceInput};
use edits::Edits;
use lodc_mesh::removal_lods;
use lodc_mesh::{Lod, OrientedTriangle, PositionIds, Simplified};
use lodc_model::{Array, BuildError, Changes, Layout, Model, StorageCost, Traffic};
use lodc_strip::{Strips, restart_list};
use std::sync::Arc;
use stored::{CheckedRemovals, REMOVALS, Stored};

/// Speed Strips.
#[derive(Clone, Debug)]
pub struct Speed {
    simplified: Arc<Simplified>,
    strips: Arc<Strips>,
    positions: Arc<PositionIds>,
    /// The submesh of each strip.
    submeshes: Vec<u32>,
    edits: Edits,
}

impl Speed {
    /// The most vertices of a strip; [`Self::build`] cuts longer ones.
    pub const LONGEST_STRIP: usize = LONGEST_TRACED;

    /// Makes the model of strips that draw exactly the mesh. Strips are worked on in parallel; the
    /// result does not depend on how many threads there are.
    ///
    /// # Errors
    /// If strips do not belong to the mesh, or change more often than those of any real mesh.
    pub fn build(simplified: &Arc<Simplified>, strips: Arc<Strips>) -> Result<Self, BuildError> {
        check_submeshes(&strips, simplified.mesh())?;
        let strips = cut_long(strips, Self::LONGEST_STRIP);
        let positions = simplified.mesh().position_ids();
        let with_dead_ends = true;
        let histories = trace::histories(simplified, &strips, &positions, with_dead_ends)?;
        Ok(Self::new(simplified, strips, positions, &histories))
    }

    /// Makes the model of what [`Model::arrays`] gave out. Every removal is replayed, so whatever
    /// is in the arrays, a cursor stays within its strips.
    ///
    /// # Errors
    /// If the arrays do not fit the mesh, the sequence or each other.
    pub fn load(simplified: &Arc<Simplified>, arrays: &[Array]) -> Result<Self, BuildError> {
        let [strips, removals] = arrays else { return Err(unknown(arrays)) };
        if strips.name != STRIPS || removals.name != REMOVALS {
            return Err(unknown(arrays));
        }
        let strips = stored_strips::from_array(strips, simplified.mesh())?;
        let stored = Stored::read(removals, strips.len())?;
        let positions = simplified.mesh().position_ids();
        let targets = simplified.collapses().targets();
        let input = TraceInput { targets, strips: &strips, positions: &positions };
        let histories = trace::in_parallel(&input, |tracer, range| {
            let mut all = History::default();
            for strip in range {
                let mut checked = CheckedRemovals::new(stored.of(strip));
                let history = tracer.trace(&input, strip..strip + 1, &mut checked)?;
                checked.finish()?;
                all.append(history);
            }
            Ok(all)
        })?;
        Ok(Self::new(simplified, Arc::new(strips), positions, &histories))
    }

    fn new(
        simplified: &Arc<Simplified>,
        strips: Arc<Strips>,
        positions: PositionIds,
        histories: &[History],
    ) -> Self {
        let edits = Edits::merge(histories, &strips, simplified.collapses().targets());
        let submeshes = strips.submeshes().collect();
        Self {
            simplified: Arc::clone(simplified),
            strips,
            positions: Arc::new(positions),
            submeshes,
            edits,
        }
    }

    /// The strips of LOD 0.
    #[must_use]
    pub fn strips(&self) -> &Arc<Strips> {
        &self.strips
    }

    /// The run-time arrays of the thesis, for the first `lod` records.
    #[must_use]
    pub fn run_time(&self, lod: Lod) -> RunTime {
        RunTime::new(self, lod)
    }

    /// For each index of the strips the first LOD at which it is not drawn any more,
    /// [`NONE`](lodc_mesh::NONE) if there is none. At any LOD before that it is what its vertex has
    /// become. Strips die as a whole before that: [`Self::removal_lods`].
    #[must_use]
    pub fn index_removal_lods(&self) -> &[u32] {
        &self.edits.index_removal_lods
    }

    /// Returns the share of the degenerate triangles that is not drawn because repetitions and dead
    /// ends are taken out: of all that live strips would draw over all LODs with their vertices of
    /// LOD 0. 0 if there are none. The thesis tells of about three quarters (3.4).
    #[must_use]
    pub fn degenerates_removed(&self) -> f64 {
        let lods = self.simplified.collapses().records() + 1;
        let shown = |removal_lod: u32| u64::from(removal_lod.min(lods));
        let live: u64 =
            removal_lods(&self.simplified, &self.positions).into_iter().map(shown).sum();
        // Triangles over all LODs, live ones too: of whole strips, and of what they still draw.
        let (mut in_full, mut drawn) = (0, 0);
        for (strip, &removal_lod) in self.edits.removal_lods.iter().enumerate() {
            let room = self.strips.range(strip);
            in_full += (room.len() as u64 - 2) * shown(removal_lod);
            drawn += self.edits.index_removal_lods[room]
                .iter()
                .map(|&at| shown(at.min(removal_lod)))
                .sum::<u64>();
            drawn -= 2 * shown(removal_lod);
        }
        let (in_full, remaining) = (in_full.saturating_sub(live), drawn.saturating_sub(live));
        if in_full == 0 { 0.0 } else { 1.0 - remaining as f64 / in_full as f64 }
    }

    /// Returns the share of the records that change the length of a strip, to none included; the
    /// thesis has 40 % (3.3.2). 0 without records.
    #[must_use]
    pub fn length_changes(&self) -> f64 {
        self.edits.length_changes()
    }

    /// For each strip the first LOD at which it draws nothing.
    #[must_use]
    pub fn removal_lods(&self) -> &[u32] {
        &self.edits.removal_lods
    }

    fn edits(&self) -> &Edits {
        &self.edits
    }
    fn positions(&self) -> &PositionIds {
        &self.positions
    }
    fn submesh_of(&self, strip: usize) -> u32 {
        self.submeshes[strip]
    }
}

impl Model for Speed {
    type Cursor = Cursor;

    fn name(&self) -> &'static str {
        "speed"
    }
    fn simplified(&self) -> &Arc<Simplified> {
        &self.simplified
    }
    fn cursor(&self) -> Cursor {
        Cursor::new(self)
    }
    fn lod(&self, cursor: &Cursor) -> Lod {
        cursor.lod()
    }
    fn seek(&self, cursor: &mut Cursor, lod: Lod, changes: &mut impl Changes) -> Traffic {
        cursor.seek(self, lod, changes)
    }
    /// Every strip that changed, whole: the variant *memory and upload* of the thesis. In its
    /// *memory* nothing is sent.
    fn sent(&self, from: Lod, to: Lod, _: Traffic) -> u64 {
        4 * self.edits.elements(&(from.0.min(to.0)..from.0.max(to.0)), to > from)
    }
    fn for_each_triangle(&self, cursor: &Cursor, mut see: impl FnMut(OrientedTriangle)) {
        for strip in 0..self.strips.len() {
            cursor.strip_triangles(self, strip).for_each(&mut see);
        }
    }
    fn drawn(&self, cursor: &Cursor) -> u64 {
        cursor.drawn()
    }
    fn strip_list(&self, cursor: &Cursor) -> Option<Vec<u32>> {
        Some(restart_list((0..self.strips.len()).map(|strip| cursor.strip(strip))))
    }
    /// `3v + I` words for vertices and strip indices, and the run-time arrays (table 3.1).
    fn storage_to(&self, lod: Lod) -> StorageCost {
        let plain = StorageCost::of_triangles(&self.simplified);
        let geometry = 12 * (plain.vertices + plain.fakes);
        let structures = self.run_time(lod).bytes();
        let primitives = 4 * self.strips.separate_indices();
        StorageCost { positions: geometry, normals: geometry, primitives, structures, ..plain }
    }
    fn arrays(&self, layout: Layout) -> Vec<Array> {
        let vertices = self.simplified.mesh().vertex_count();
        vec![
            stored_strips::to_array(&self.strips, vertices, layout),
            stored::to_array(&self.edits.removals_by_strip()),
        ]
    }
}

fn unknown(arrays: &[Array]) -> BuildError {
    BuildError::Arrays { given: arrays.iter().map(|a| a.name.clone()).collect() }
}
