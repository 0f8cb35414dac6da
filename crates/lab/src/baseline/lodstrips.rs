//! `LodStrips` (Ramos and Chover 2004, 2006): strips, and for each record a list of offsets that
//! change. Record *k* of a collapse sequence removes vertex *k*, which becomes its target.
//!
//! The ancestor of Speed Strips: the same changes and repetitions of the same strips (dead ends,
//! what comes before the first drawn triangle and after the last, stay), but each entry names its
//! strip, and entries are applied one by one, record by record, to strips that grow and shrink by
//! themselves.

use lodc_lod::trace::{self, History, Removal, RemovalKind};
use lodc_lod::{LONGEST_TRACED, check_submeshes, cut_long};
use lodc_mesh::{Lod, OrientedTriangle, PositionIds, Simplified};
use lodc_model::Difference;
use lodc_model::{Array, BuildError, Changes, Layout, Model, StorageCost, Traffic};
use lodc_strip::{Strips, live_triangles, restart_list};
use std::sync::Arc;

/// One change of one strip: of an index, or of how often something is repeated.
#[derive(Clone, Copy, Debug)]
struct Entry {
    strip: u32,
    offset: u32,
    /// 0: the index at `offset` changes. Else the number of elements of a repetition that is
    /// removed, of a vertex (positive) or an edge (negative).
    repetitions: i32,
}

/// `LodStrips` over strips of a mesh.
#[derive(Clone, Debug)]
pub struct LodStrips {
    simplified: Arc<Simplified>,
    strips: Arc<Strips>,
    positions: Arc<PositionIds>,
    /// The submesh of each strip.
    submeshes: Vec<u32>,
    /// For each strip the first LOD at which it draws nothing.
    removal_lods: Vec<u32>,
    /// Start of each record's entries, and end of the last one's.
    entry_starts: Vec<u32>,
    /// In the order in which coarsening applies them: of each strip changes first, then what goes,
    /// from the back.
    entries: Vec<Entry>,
}

/// A cursor over [`LodStrips`].
#[derive(Clone, Debug)]
pub struct Cursor {
    lod: u32,
    strips: Vec<Vec<u32>>,
}

impl LodStrips {
    /// Makes the model of strips that draw exactly the mesh, cut to [`LONGEST_TRACED`] vertices.
    ///
    /// # Errors
    /// If strips do not belong to the mesh, or change more often than those of any real mesh.
    pub fn build(simplified: &Arc<Simplified>, strips: Arc<Strips>) -> Result<Self, BuildError> {
        check_submeshes(&strips, simplified.mesh())?;
        let strips = cut_long(strips, LONGEST_TRACED);
        let positions = simplified.mesh().position_ids();
        let with_dead_ends = false;
        let histories = trace::histories(simplified, &strips, &positions, with_dead_ends)?;
        let (entry_starts, entries) =
            by_record(&histories, simplified.collapses().records() as usize);
        Ok(Self {
            simplified: Arc::clone(simplified),
            submeshes: strips.submeshes().collect(),
            strips,
            positions: Arc::new(positions),
            removal_lods: histories.iter().flat_map(|h| &h.removal_lods).copied().collect(),
            entry_starts,
            entries,
        })
    }

    /// Bytes that the structure really holds, positions only: three words for each entry.
    #[must_use]
    pub fn tight_bytes(&self) -> u64 {
        let words = 3 * self.simplified.mesh().vertex_count()
            + self.entry_starts.len()
            + 3 * self.entries.len();
        4 * (words as u64
            + u64::from(self.simplified.collapses().records())
            + self.strips.separate_indices())
    }

    /// Returns the triangles that one strip draws at the LOD where a cursor is.
    fn drawn_by<'a>(
        &'a self,
        cursor: &'a Cursor,
        strip: usize,
    ) -> impl Iterator<Item = OrientedTriangle> + 'a {
        let live = self.removal_lods[strip] > cursor.lod;
        let elements: &[u32] = if live { &cursor.strips[strip] } else { &[] };
        live_triangles(elements, self.submeshes[strip], &self.positions)
    }

    fn entries(&self, record: u32) -> &[Entry] {
        &self.entries[self.entry_starts[record as usize] as usize
            ..self.entry_starts[record as usize + 1] as usize]
    }

    fn coarsen(&self, cursor: &mut Cursor, record: u32) -> u64 {
        let target = self.simplified.collapses().targets()[record as usize];
        let mut written = 0;
        for entry in self.entries(record) {
            let (strip, offset) = (&mut cursor.strips[entry.strip as usize], entry.offset as usize);
            if entry.repetitions == 0 {
                strip[offset] = target;
                written += 1;
            } else {
                strip.drain(offset..offset + entry.repetitions.unsigned_abs() as usize);
                written += (strip.len() - offset) as u64;
            }
        }
        written
    }

    fn refine(&self, cursor: &mut Cursor, record: u32) -> u64 {
        let mut written = 0;
        for entry in self.entries(record).iter().rev() {
            let (strip, offset) = (&mut cursor.strips[entry.strip as usize], entry.offset as usize);
            if entry.repetitions == 0 {
                strip[offset] = record;
                written += 1;
            } else {
                // The last vertex goes on, or the last two (an edge).
                let (count, period) =
                    (entry.repetitions.unsigned_abs(), if entry.repetitions > 0 { 1 } else { 2 });
                let pattern = [strip[offset.saturating_sub(2)], strip[offset - 1]];
                strip.splice(
                    offset..offset,
                    (0..count as usize).map(|i| pattern[i % period + 2 - period]),
                );
                written += (strip.len() - offset) as u64;
            }
        }
        written
    }

    /// The strips that some records change.
    fn affected(&self, fine: u32, coarse: u32) -> Vec<u32> {
        let entries = &self.entries[self.entry_starts[fine as usize] as usize
            ..self.entry_starts[coarse as usize] as usize];
        let mut strips: Vec<u32> = entries.iter().map(|e| e.strip).collect();
        let died = |s: &u32| (fine + 1..=coarse).contains(&self.removal_lods[*s as usize]);
        strips.extend((0..self.removal_lods.len() as u32).filter(died));
        strips.sort_unstable();
        strips.dedup();
        strips
    }

    fn move_to<C: Changes>(&self, cursor: &mut Cursor, to: u32, changes: &mut C) -> Traffic {
        let from = cursor.lod;
        let (fine, coarse) = (from.min(to), from.max(to));
        let walk = |cursor: &mut Cursor| -> Traffic {
            let rewritten: u64 = if to > from {
                (fine..coarse).map(|record| self.coarsen(cursor, record)).sum()
            } else {
                (fine..coarse).rev().map(|record| self.refine(cursor, record)).sum()
            };
            cursor.lod = to;
            Traffic { records: coarse - fine, rewritten }
        };
        if !C::REPORTED {
            return walk(cursor);
        }
        let affected = self.affected(fine, coarse);
        let mut difference = Difference::default();
        for &strip in &affected {
            difference.add_before(self.drawn_by(cursor, strip as usize));
        }
        let traffic = walk(cursor);
        for (number, &strip) in affected.iter().enumerate() {
            difference.report_after(number, self.drawn_by(cursor, strip as usize), changes);
        }
        traffic
    }
}

impl Model for LodStrips {
    type Cursor = Cursor;

    fn name(&self) -> &'static str {
        "lodstrips"
    }
    fn simplified(&self) -> &Arc<Simplified> {
        &self.simplified
    }
    fn cursor(&self) -> Cursor {
        Cursor { lod: 0, strips: self.strips.iter().map(<[u32]>::to_vec).collect() }
    }
    fn lod(&self, cursor: &Cursor) -> Lod {
        Lod(cursor.lod)
    }
    fn seek(&self, cursor: &mut Cursor, lod: Lod, changes: &mut impl Changes) -> Traffic {
        self.move_to(cursor, self.simplified.collapses().floor(lod).0, changes)
    }
    fn for_each_triangle(&self, cursor: &Cursor, see: impl FnMut(OrientedTriangle)) {
        (0..self.strips.len()).flat_map(|strip| self.drawn_by(cursor, strip)).for_each(see);
    }
    fn drawn(&self, cursor: &Cursor) -> u64 {
        let live = (0..self.strips.len()).filter(|&strip| self.removal_lods[strip] > cursor.lod);
        live.map(|strip| cursor.strips[strip].len() as u64).sum()
    }
    fn strip_list(&self, cursor: &Cursor) -> Option<Vec<u32>> {
        let live = (0..self.strips.len()).filter(|&strip| self.removal_lods[strip] > cursor.lod);
        Some(restart_list(live.map(|strip| cursor.strips[strip].as_slice())))
    }
    /// `3v + I` words for vertices and strip indices; for each record its target and where its list
    /// starts; for each strip of a record a word and a byte (its number and how much follows), for
    /// each change a word, for each repetition two.
    fn storage_to(&self, lod: Lod) -> StorageCost {
        let plain = StorageCost::of_triangles(&self.simplified);
        let geometry = 12 * (plain.vertices + plain.fakes);
        let records = self.simplified.collapses().floor(lod).0;
        let bytes_of_record = |record| {
            let entries = self.entries(record);
            let strips = entries.chunk_by(|a, b| a.strip == b.strip).count() as u64;
            let words: u64 = entries.iter().map(|e| if e.repetitions == 0 { 1 } else { 2 }).sum();
            5 * strips + 4 * words
        };
        let structures = 8 * u64::from(records) + (0..records).map(bytes_of_record).sum::<u64>();
        let primitives = 4 * self.strips.separate_indices();
        StorageCost { positions: geometry, normals: geometry, primitives, structures, ..plain }
    }
    // A baseline is measured, and never stored.
    fn arrays(&self, _: Layout) -> Vec<Array> {
        Vec::new()
    }
}

/// All entries in order of records (a counting sort).
fn by_record(histories: &[History], records: usize) -> (Vec<u32>, Vec<Entry>) {
    let mut entry_starts = vec![0u32; records + 1];
    for event in histories.iter().flat_map(|h| &h.events) {
        entry_starts[event.record as usize + 1] += event.changes + event.removals;
    }
    for k in 0..records {
        entry_starts[k + 1] += entry_starts[k];
    }
    let mut next_slots = entry_starts.clone();
    let mut entries =
        vec![Entry { strip: 0, offset: 0, repetitions: 0 }; entry_starts[records] as usize];
    for history in histories {
        let (mut changes, mut removals) = (history.changes.iter(), history.removals.iter());
        for event in &history.events {
            let strip = event.strip;
            let change = changes.by_ref().take(event.changes as usize);
            let mut event_entries: Vec<Entry> =
                change.map(|&offset| Entry { strip, offset, repetitions: 0 }).collect();
            let gone = removals.by_ref().take(event.removals as usize);
            let repetitions = |r: &Removal| {
                if r.kind == RemovalKind::Edge { -(r.count as i32) } else { r.count as i32 }
            };
            let gone = gone.map(|r| Entry { strip, offset: r.offset, repetitions: repetitions(r) });
            let gone: Vec<Entry> = gone.collect();
            event_entries.extend(gone.into_iter().rev());
            let slot = &mut next_slots[event.record as usize];
            entries[*slot as usize..*slot as usize + event_entries.len()]
                .copy_from_slice(&event_entries);
            *slot += event_entries.len() as u32;
        }
    }
    (entry_starts, entries)
}
