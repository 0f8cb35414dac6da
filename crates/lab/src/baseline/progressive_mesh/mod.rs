//! Progressive Meshes (Hoppe 1996, 1998): a mesh with neighbour pointers, and a record for each
//! edge collapse that can be undone as a vertex split.
//!
//! A record names where the fan of triangles begins that changes from one vertex to the other, and
//! how many triangles it has; the neighbour pointers lead through it. A dying triangle is taken out
//! from between its neighbours and keeps its own pointers, so that it can be put back. That is
//! Hoppe's `flclw` and its rotation codes, made to hold for any sequence: a record may have several
//! fans (borders, seams, edges of more than two triangles), and all records of a step apply
//! together. The index list that would be drawn is up to date after every step: triangles are in
//! reverse order of their removal LODs, so the live ones are the first of each submesh.

mod connect;
mod cursor;
mod moving;
mod record;
mod walk;

pub use cursor::Cursor;

use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use lodc_model::{Array, BuildError, Changes, Layout, Model, StorageCost, Traffic};
use record::Records;
use std::sync::Arc;

/// A Progressive Mesh over a given sequence.
#[derive(Clone, Debug)]
pub struct ProgressiveMesh {
    simplified: Arc<Simplified>,
    records: Records,
}

impl ProgressiveMesh {
    /// Makes the records by walking down the sequence once. Linear, except for sorting edges.
    ///
    /// # Errors
    /// If the triangles of a submesh are not in reverse order of their disappearance.
    pub fn build(simplified: &Arc<Simplified>) -> Result<Self, BuildError> {
        let records = walk::records(simplified);
        for (submesh, s) in simplified.mesh().submeshes().iter().enumerate() {
            if let Some(i) =
                records.removal_lods[s.triangles()].windows(2).position(|pair| pair[0] < pair[1])
            {
                return Err(BuildError::TriangleOrder {
                    submesh,
                    triangle: s.first_triangle as usize + i + 1,
                });
            }
        }
        Ok(Self { simplified: Arc::clone(simplified), records })
    }

    /// Returns the number of fans of triangles a record rewrites.
    ///
    /// # Panics
    /// If there is no such record.
    #[must_use]
    pub fn fans(&self, record: u32) -> usize {
        self.records.fans_of(record).len()
    }

    /// Bytes that this structure really holds, positions only: half-edge collapses need no new
    /// positions, so a record is its target, its fans (where they begin, how many corners) and its
    /// place among them; a triangle has three corners, three neighbours, the edge it dies by and
    /// when. Counted with four bytes a number.
    #[must_use]
    pub fn tight_bytes(&self) -> u64 {
        let plain = StorageCost::of_triangles(&self.simplified);
        let triangles = self.simplified.mesh().triangles().len() as u64;
        let records = u64::from(self.simplified.collapses().records());
        4 * (3 * (plain.vertices + plain.fakes)
            + 8 * triangles
            + 2 * records
            + 2 * self.records.fans.len() as u64)
    }
}

impl ProgressiveMesh {
    /// Bytes of a progressive transmission in Hoppe's words (thesis, table 4.3): for each record
    /// the 8 words of [`storage_to`](Model::storage_to), with normals 14; before them the vertex
    /// that the sequence ends with.
    #[must_use]
    pub fn packages(&self, normals: bool) -> u64 {
        let records = u64::from(self.simplified.collapses().records());
        let (split, vertex) = if normals { (14, 6) } else { (8, 3) };
        4 * (vertex + split * records)
    }
}

impl Model for ProgressiveMesh {
    type Cursor = Cursor;

    fn name(&self) -> &'static str {
        "progressive_mesh"
    }
    fn simplified(&self) -> &Arc<Simplified> {
        &self.simplified
    }
    fn cursor(&self) -> Cursor {
        Cursor::new(&self.simplified, &self.records)
    }
    fn lod(&self, cursor: &Cursor) -> Lod {
        cursor.lod(&self.simplified)
    }
    fn seek(&self, cursor: &mut Cursor, lod: Lod, changes: &mut impl Changes) -> Traffic {
        cursor.seek(&self.simplified, &self.records, lod, changes)
    }
    /// Each rewritten index by itself, and for each submesh how many triangles are drawn: the least
    /// that could be sent.
    fn sent(&self, _: Lod, _: Lod, traffic: Traffic) -> u64 {
        let counts =
            if traffic.records == 0 { 0 } else { self.simplified.mesh().submeshes().len() as u64 };
        4 * (traffic.rewritten + counts)
    }
    fn for_each_triangle(&self, cursor: &Cursor, see: impl FnMut(OrientedTriangle)) {
        cursor.triangles(&self.simplified).for_each(see);
    }
    fn drawn(&self, cursor: &Cursor) -> u64 {
        cursor.drawn()
    }
    /// In Hoppe's own words, which is what the thesis's tables fit: the mesh `3v` positions, `v`
    /// wedges, `3f` corners and `3f` neighbours, and for each record 8 words: where (1), rotation
    /// codes (1), two position deltas (6). With normals 6 more words per record, two wedge deltas;
    /// those of the base mesh are not counted. For a closed mesh `24v`, with normals `30v`. Fakes
    /// are there only while their records are, so they count as records.
    fn storage_to(&self, lod: Lod) -> StorageCost {
        let plain = StorageCost::of_triangles(&self.simplified);
        let records = u64::from(self.simplified.collapses().floor(lod).0);
        let triangles = self.simplified.mesh().triangles().len() as u64;
        StorageCost {
            structures: 4 * (plain.vertices + 3 * triangles + 8 * records),
            normals: 24 * records,
            ..plain
        }
    }
    fn arrays(&self, _: Layout) -> Vec<Array> {
        Vec::new()
    }
}
