//! The tables of the thesis for Masking Strips (4.2.1): `InfoUpdate` and `InfoStrip`, and the bytes
//! that they take.

use super::Masking;
use lodc_mesh::Lod;
use lodc_model::StorageCost;

/// One entry of the thesis's list of records. A record that changes 255 strips or more has several:
/// one that has 255 is continued by the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InfoUpdate {
    /// The target of the removed vertex, whose number is that of the record.
    pub vertex: u32,
    /// Number of strips that are changed.
    pub strips_affected: u8,
    /// True if the next record belongs to the same step.
    pub next_update: bool,
}

/// The update of one strip by one record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InfoStrip {
    /// The strip.
    pub strip: u32,
    /// A bit for each position, the first lowest: those that hold the removed vertex and become its
    /// target. Positions that are not drawn at any coarser LOD are left out: what they hold does
    /// not matter.
    pub position_mask: u16,
    /// The positions that are drawn at the end of the step; none if no triangle of the strip is
    /// left.
    pub filter_mask: u16,
}

impl Masking {
    /// The thesis's list of records.
    pub fn info_updates(&self) -> impl Iterator<Item = InfoUpdate> {
        let parts = self.simplified.collapses().parts();
        let mut ends = parts.step_ends.iter().copied().peekable();
        parts.targets.iter().enumerate().flat_map(move |(record, &vertex)| {
            let next_update = ends.next_if_eq(&(record as u32 + 1)).is_none();
            let strips = self.updates.in_records(&(record as u32..record as u32 + 1)).strips.len();
            (0..=strips / 255).map(move |entry| {
                let strips_affected = (strips - 255 * entry).min(255) as u8;
                InfoUpdate { vertex, strips_affected, next_update }
            })
        })
    }

    /// Returns the updates of strips by a record, in order of strips. Takes the logarithm of a
    /// strip's entries for each.
    ///
    /// # Panics
    /// If there is no such record.
    pub fn info_strips(&self, record: u32) -> impl ExactSizeIterator<Item = InfoStrip> {
        self.updates.in_records(&(record..record + 1)).strips.iter().map(move |&strip| {
            let history = &self.entries[self.history(strip as usize)];
            let entry = history[history.partition_point(|entry| entry.record < record)];
            InfoStrip { strip, position_mask: entry.positions, filter_mask: entry.filter }
        })
    }
}

/// Returns the storage of the tables down to the end of a step: vertices and strips are those of
/// the whole model.
pub(super) fn storage(model: &Masking, lod: Lod) -> StorageCost {
    let plain = StorageCost::of_triangles(&model.simplified);
    let geometry = 12 * (plain.vertices + plain.fakes);
    let counts = (0..lod.0)
        .map(|record| model.updates.in_records(&(record..record + 1)).strips.len() as u64);
    // An `InfoUpdate` is five bytes, and 255 strips need another one.
    let updates: u64 = counts.map(|strips| 5 * (1 + strips / 255)).sum();
    let bytes_of_strip = |strip: usize| {
        let history = &model.entries[model.history(strip)];
        let entries = history.partition_point(|entry| entry.record < lod.0) as u64;
        // The entry with which a strip ends needs no masks: nothing of it is drawn any more.
        let masked =
            history[..entries as usize].iter().filter(|entry| entry.filter != 0).count() as u64;
        4 * entries + 2 * masked * model.strips.range(strip).len().div_ceil(8) as u64
    };
    let strips: u64 = (0..model.strips.len()).map(bytes_of_strip).sum();
    let primitives = 4 * model.strips.separate_indices();
    StorageCost {
        positions: geometry,
        normals: geometry,
        primitives,
        structures: updates + strips,
        ..plain
    }
}
