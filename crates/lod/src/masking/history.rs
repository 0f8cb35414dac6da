//! The history of each strip: which of its indices every record changes (its position mask), and
//! what is drawn of it afterwards (its filter mask).

use super::filters::Filters;
use super::pattern::Pattern;
use lodc_mesh::{PositionIds, Simplified};
use lodc_strip::StripSet;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// The update of one strip by one record: the `InfoStrip` of the thesis (4.2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) record: u32,
    /// The positions that hold the vertex which the record removes.
    pub(super) positions: u16,
    /// The positions that are drawn after the step of the record; 0 if no triangle is left.
    pub(super) filter: u16,
}

/// The entries of all strips.
#[derive(Clone, Debug)]
pub(super) struct Histories {
    /// Start of each strip's entries, and end of the last one's.
    pub(super) entry_starts: Vec<u32>,
    /// Strip by strip, in order of records.
    pub(super) entries: Vec<Entry>,
}

/// All strips together may have this many entries for each of their indices and each record, and
/// [`ENTRIES_OF_ANY_MESH`] more. Sequences of real meshes make about two for each index; one in
/// which a vertex of thousands of triangles moves on and on makes far more. Chosen by hand.
const MAX_ENTRIES_PER_INDEX: u64 = 32;
/// So that small meshes are never refused. Chosen by hand.
const ENTRIES_OF_ANY_MESH: u64 = 1_000_000;

/// Strips that one thread works on at a time, with patterns remembered from one to the next. Chosen
/// by hand.
const STRIPS_PER_BLOCK: usize = 1024;

/// Follows every strip by itself. A strip has no entries after the step in which its last triangle
/// dies.
///
/// `None` if there would be far more entries than any sensible sequence makes.
pub(super) fn histories(
    simplified: &Simplified,
    strips: &StripSet,
    positions: &PositionIds,
) -> Option<Histories> {
    let step_end_of = simplified.collapses().step_ends_by_record();
    let targets = simplified.collapses().targets();
    let max_entries = MAX_ENTRIES_PER_INDEX * (strips.indices().len() + targets.len()) as u64
        + ENTRIES_OF_ANY_MESH;
    let entries = AtomicU64::new(0);
    let blocks: Vec<_> = (0..strips.len().div_ceil(STRIPS_PER_BLOCK)).collect();
    let blocks = blocks.into_par_iter().map_init(Filters::new, |filters, block| {
        let mut tracer =
            Tracer { targets, step_end_of: &step_end_of, positions, filters, entries: Vec::new() };
        let mut counts = Vec::with_capacity(STRIPS_PER_BLOCK);
        for strip in block * STRIPS_PER_BLOCK..strips.len().min((block + 1) * STRIPS_PER_BLOCK) {
            let before = tracer.entries.len();
            tracer.trace(strips.strip(strip), (max_entries + 1) as usize);
            counts.push(tracer.entries.len() - before);
            let added = counts[counts.len() - 1] as u64;
            // Whether the sum of all blocks exceeds the limit does not depend on their order.
            if entries.fetch_add(added, Ordering::Relaxed) + added > max_entries {
                return None;
            }
        }
        Some((counts, tracer.entries))
    });
    let blocks: Vec<_> = blocks.collect::<Option<_>>()?;
    let mut entry_starts = Vec::with_capacity(strips.len() + 1);
    let mut all = Vec::with_capacity(blocks.iter().map(|(_, entries)| entries.len()).sum());
    let mut first = 0;
    entry_starts.push(first);
    for (counts, entries) in blocks {
        entry_starts.extend(counts.iter().map(|&count| {
            first += count as u32;
            first
        }));
        all.extend(entries);
    }
    Some(Histories { entry_starts, entries: all })
}

/// Follows strips through the sequence and writes down their entries.
struct Tracer<'a> {
    targets: &'a [u32],
    /// For each record the end of its step.
    step_end_of: &'a [u32],
    positions: &'a PositionIds,
    filters: &'a mut Filters,
    entries: Vec<Entry>,
}

impl Tracer<'_> {
    /// Adds the entries of one strip, at most some more than `limit`.
    fn trace(&mut self, strip: &[u32], limit: usize) {
        let first = self.entries.len();
        let mut state = [0; super::pattern::LONGEST];
        let state = &mut state[..strip.len()];
        state.copy_from_slice(strip);
        if self.filter(state) == 0 {
            return;
        }
        // Vertex k goes in record k: the next record of a strip is the least vertex in it.
        while let Some(&next) = state.iter().min()
            && let Some(&end) = self.step_end_of.get(next as usize)
            && self.entries.len() - first <= limit
        {
            let step = self.entries.len();
            while let Some(&record) = state.iter().min()
                && record < end
            {
                let target = self.targets[record as usize];
                let mut positions = 0;
                for (index, v) in state.iter_mut().enumerate() {
                    positions |= u16::from(*v == record) << index;
                    *v = if *v == record { target } else { *v };
                }
                self.entries.push(Entry { record, positions, filter: 0 });
            }
            let filter = self.filter(state);
            self.entries[step..].iter_mut().for_each(|entry| entry.filter = filter);
            if filter == 0 {
                break;
            }
        }
        self.drop_unneeded(first, strip.len());
    }

    /// Drops from a strip's entries the positions that no later filter keeps: they are
    /// not read again before the cursor has gone back to an LOD that still draws them. Then drops
    /// the entries that have become empty.
    fn drop_unneeded(&mut self, first: usize, len: usize) {
        let mut needed = 0;
        for entry in self.entries[first..].iter_mut().rev() {
            needed |= entry.filter;
            entry.positions &= needed;
        }
        let (mut written, mut filter) = (first, u16::MAX >> (16 - len));
        for index in first..self.entries.len() {
            let entry = self.entries[index];
            let end = |entry: &Entry| self.step_end_of[entry.record as usize];
            let is_last_of_step =
                self.entries.get(index + 1).is_none_or(|next| end(next) != end(&entry));
            if entry.positions != 0 || (is_last_of_step && entry.filter != filter) {
                filter = entry.filter;
                self.entries[written] = entry;
                written += 1;
            }
        }
        self.entries.truncate(written);
    }

    /// Returns the filter of a strip whose vertices are these.
    fn filter(&mut self, state: &[u32]) -> u16 {
        let position_id = |v: u32| self.positions.of_vertex[v as usize];
        self.filters.filter(&Pattern::new(state, position_id))
    }
}
