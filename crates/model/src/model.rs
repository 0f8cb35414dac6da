//! The trait of multiresolution models: immutable structures that show any LOD of a mesh through
//! cursors.

use crate::{Array, Changes, Layout, StorageCost};
use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use std::sync::Arc;

/// A multiresolution model of one mesh. It is immutable and storable; a cursor holds the current
/// LOD and whatever has to change with it.
///
/// A step is the records of one collapse, and only ends of steps are shown. Whichever way a cursor
/// came to one, the model shows exactly [`Simplified::triangles_at`] that LOD.
pub trait Model {
    /// The state of one view of the model: its current LOD and what changes with it.
    type Cursor;

    /// Returns the model's name in options, files and reports.
    fn name(&self) -> &'static str;

    /// The mesh and the collapse sequence that this is a model of.
    fn simplified(&self) -> &Arc<Simplified>;

    /// A new cursor at LOD 0.
    fn cursor(&self) -> Self::Cursor;

    /// Returns the LOD where a cursor is: always the end of a step, or 0.
    fn lod(&self, cursor: &Self::Cursor) -> Lod;

    /// Moves a cursor to the LOD shown for `lod` (rounded down to the end of a step), finer or
    /// coarser, near or far. `changes` is told exactly the triangles that are removed and added:
    /// none that stays, none twice.
    fn seek(&self, cursor: &mut Self::Cursor, lod: Lod, changes: &mut impl Changes) -> Traffic;

    /// Bytes that a program with the model on a GPU sends there for a move that cost `traffic`:
    /// four for each rewritten element, unless a model says otherwise.
    fn sent(&self, _from: Lod, _to: Lod, traffic: Traffic) -> u64 {
        4 * traffic.rewritten
    }

    /// Calls `visit` with each triangle shown, in the order in which they would be drawn.
    fn for_each_triangle(&self, cursor: &Self::Cursor, visit: impl FnMut(OrientedTriangle));

    /// The triangles shown, in the order in which they would be drawn.
    fn triangles(&self, cursor: &Self::Cursor) -> Vec<OrientedTriangle> {
        let count = self.simplified().collapses().triangles_at(self.lod(cursor));
        let mut triangles = Vec::with_capacity(count as usize);
        self.for_each_triangle(cursor, |t| triangles.push(t));
        triangles
    }

    /// Returns the number of indices that are drawn: three for each triangle, or all those of the
    /// strips as they are now.
    fn drawn(&self, cursor: &Self::Cursor) -> u64;

    /// The strips as they are now, each followed by [`NONE`](lodc_mesh::NONE), which restarts
    /// primitives on a graphics device; none if the model draws lists of triangles.
    fn strip_list(&self, _cursor: &Self::Cursor) -> Option<Vec<u32>> {
        None
    }

    /// Returns the storage of the model.
    fn storage(&self) -> StorageCost {
        self.storage_to(self.simplified().collapses().last())
    }

    /// Returns its storage if LODs coarser than the one shown for `lod` are never wanted (thesis
    /// eq. 5.5 stops at 95 %).
    fn storage_to(&self, lod: Lod) -> StorageCost;

    /// Returns the arrays that have to be stored besides the mesh and the sequence.
    fn arrays(&self, layout: Layout) -> Vec<Array>;
}

/// The cost of one move of a cursor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Records of the collapse sequence between the two LODs.
    pub records: u32,
    /// Elements of the drawn data (vertices or indices) that were rewritten.
    pub rewritten: u64,
}
