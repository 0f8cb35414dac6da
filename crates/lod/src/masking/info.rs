//! The tables of the thesis (4.2.1), what they take to store, and how much is drawn (fig. 4.9).

use super::Masking;
use crate::{Model, StorageCost};
use lodc_mesh::Lod;

/// One entry of the thesis's list of records. A record that changes 255 strips or more has several: one that has 255 is
/// continued by the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InfoUpdate {
    /// What the removed vertex becomes. (Which one is removed is the number of the record.)
    pub vertex: u32,
    /// How many strips are changed.
    pub strips_affected: u8,
    /// Whether the next record belongs to the same step.
    pub next_update: bool,
}

/// What a record does to one strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InfoStrip {
    /// The strip.
    pub strip: u32,
    /// A bit for each position, the first lowest: those that hold the removed vertex and become its target.
    pub position_mask: u64,
    /// The positions that are drawn at the end of the step; none if no triangle of the strip is left.
    pub filter_mask: u64,
}

/// How many indices are drawn at a LOD.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DrawnIndices {
    /// The LOD.
    pub lod: Lod,
    /// Indices of the filtered strips.
    pub strips: u64,
    /// Indices of a list of the same triangles: three for each.
    pub triangles: u64,
}

impl Masking {
    /// The thesis's list of records.
    pub fn info_updates(&self) -> impl Iterator<Item = InfoUpdate> {
        let parts = self.simplified.collapses().parts();
        let mut ends = parts.step_ends.iter().copied().peekable();
        parts.targets.iter().enumerate().flat_map(move |(record, &vertex)| {
            let next_update = ends.next_if_eq(&(record as u32 + 1)).is_none();
            let strips = (self.starts[record + 1] - self.starts[record]) as usize;
            (0..=strips / 255).map(move |entry| {
                let strips_affected = (strips - 255 * entry).min(255) as u8;
                InfoUpdate { vertex, strips_affected, next_update }
            })
        })
    }

    /// What a record does to the strips, in order of strips. Takes the logarithm of a strip's entries for each.
    ///
    /// # Panics
    /// If there is no such record.
    pub fn info_strips(&self, record: u32) -> impl ExactSizeIterator<Item = InfoStrip> {
        let places = self.starts[record as usize] as usize..self.starts[record as usize + 1] as usize;
        self.affected[places].iter().map(move |&strip| {
            let history = &self.entries[self.history(strip as usize)];
            let entry = history[history.partition_point(|entry| entry.record < record)];
            InfoStrip { strip, position_mask: entry.positions, filter_mask: entry.filter }
        })
    }

    /// [`Model::storage`] of a model that goes down no further than `lod`: vertices and strips are the same, records and
    /// what they do to strips are those before it (as eq. 5.5 counts).
    #[must_use]
    pub fn storage_to(&self, lod: Lod) -> StorageCost {
        let plain = StorageCost::of_triangles(&self.simplified);
        let geometry = 12 * (plain.vertices + plain.fakes);
        let records = lod.0.min(self.simplified.collapses().records());
        let counts = self.starts.windows(2).take(records as usize).map(|start| u64::from(start[1] - start[0]));
        // Five bytes a record, and five more whenever 255 is not enough.
        let updates: u64 = counts.map(|strips| 5 * (1 + strips / 255)).sum();
        let of_strip = |strip: usize| {
            let history = &self.entries[self.history(strip)];
            let entries = history.partition_point(|entry| entry.record < records) as u64;
            entries * (4 + 2 * self.strips.range(strip).len().div_ceil(8) as u64)
        };
        let strips: u64 = (0..self.strips.len()).map(of_strip).sum();
        let primitives = 4 * self.strips.separate_indices();
        StorageCost { positions: geometry, normals: geometry, primitives, structures: updates + strips, ..plain }
    }

    /// How many indices are drawn on a sweep of `steps` equal moves (at least 1) from LOD 0 to the coarsest (thesis fig. 4.9).
    #[must_use]
    pub fn drawn_indices(&self, steps: u32) -> Vec<DrawnIndices> {
        let (collapses, mut cursor) = (self.simplified.collapses(), self.cursor());
        let stops = (0..=steps.max(1)).map(|i| {
            let lod = u64::from(collapses.records()) * u64::from(i) / u64::from(steps.max(1));
            self.seek(&mut cursor, Lod(lod as u32), &mut ());
            let lod = self.lod(&cursor);
            DrawnIndices { lod, strips: cursor.indices(), triangles: 3 * u64::from(collapses.triangles_at(lod)) }
        });
        stops.collect()
    }
}
