//! Updates of strips in the order of records, ready to be applied by near moves.
//!
//! Full strips never move in a cursor's buffer, so what a record writes is a list of offsets,
//! whatever their strips. Where it leaves a strip's filter as it was (three updates of five), the
//! filtered copy is updated at single offsets as well. Only where the filter changes is the strip
//! copied anew, and only once in a move.

use super::LONGEST;
use super::history::{Entry, Histories};
use lodc_mesh::NONE;
use std::ops::Range;

/// The words of a strip in a cursor's buffer: as many words for the full strip, then as many for
/// its filtered copy.
pub(super) const SLOT_WORDS: usize = 2 * LONGEST;

/// Where a record's elements start in each list; they end where the next record's start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Starts {
    strips: u32,
    writes: u32,
    filter_changes: u32,
}

/// A change of a strip's filter: its filtered copy is made anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FilterChange {
    pub(super) strip: u32,
    /// The record with which the strip's filter changes again, [`NONE`] for none.
    pub(super) next: u32,
    /// The LOD from which on the filter was `previous_filter`.
    pub(super) since: u32,
    /// The positions that are drawn from now on, and until now.
    pub(super) filter: u16,
    pub(super) previous_filter: u16,
}

/// The updates of all strips, by record, then strip.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Updates {
    /// One for each record, and one more.
    starts: Vec<Starts>,
    /// The strips that are changed.
    strips: Vec<u32>,
    /// Offsets in a cursor's buffer that are written.
    offsets: Vec<u32>,
    /// The target that is written there, and the vertex that the record removes.
    targets: Vec<u32>,
    vertices: Vec<u32>,
    filter_changes: Vec<FilterChange>,
}

/// The changes of some consecutive records: slices of the lists of [`Updates`].
#[derive(Clone, Copy, Debug)]
pub(super) struct UpdatesOfRecords<'a> {
    pub(super) strips: &'a [u32],
    pub(super) offsets: &'a [u32],
    pub(super) targets: &'a [u32],
    pub(super) vertices: &'a [u32],
    pub(super) filter_changes: &'a [FilterChange],
}

/// The filter of a strip while its entries are sorted.
#[derive(Clone, Copy)]
struct LatestFilter {
    filter: u16,
    /// The LOD from which on it holds.
    since: u32,
    /// The index of its change in [`Updates::filter_changes`]; `usize::MAX` before the first.
    change: usize,
}

impl Updates {
    /// Sorts the entries of strips by record. `lengths` are those of the strips.
    pub(super) fn new(histories: &Histories, lengths: &[usize], targets: &[u32]) -> Self {
        let mut updates = Self { starts: Vec::with_capacity(targets.len() + 1), ..Self::default() };
        updates.strips.reserve_exact(histories.entries.len());
        let mut latest: Vec<LatestFilter> = lengths
            .iter()
            .map(|&length| LatestFilter {
                filter: whole_strip(length),
                since: 0,
                change: usize::MAX,
            })
            .collect();
        for (strip, entry) in by_record(histories, targets.len()) {
            updates.start_records(entry.record as usize + 1);
            updates.strips.push(strip);
            let LatestFilter { filter: previous_filter, since, change } = latest[strip as usize];
            let kept_filter = if previous_filter == entry.filter { previous_filter } else { 0 };
            updates.write(strip, entry, kept_filter, targets[entry.record as usize]);
            if previous_filter != entry.filter {
                let filter = entry.filter;
                if let Some(change) = updates.filter_changes.get_mut(change) {
                    change.next = entry.record;
                }
                let (holds_since, change) = (entry.record + 1, updates.filter_changes.len());
                latest[strip as usize] = LatestFilter { filter, since: holds_since, change };
                updates.filter_changes.push(FilterChange {
                    strip,
                    next: NONE,
                    since,
                    filter,
                    previous_filter,
                });
            }
        }
        updates.start_records(targets.len() + 1);
        updates
    }

    /// Adds what an entry writes: to the full strip, and to the filtered copy where `kept_filter`
    /// is the filter before and after; 0 if it changes.
    fn write(&mut self, strip: u32, entry: &Entry, kept_filter: u16, target: u32) {
        let full = strip * SLOT_WORDS as u32;
        for at in (0..LONGEST as u32).filter(|at| entry.positions >> at & 1 == 1) {
            self.offsets.push(full + at);
            if kept_filter >> at & 1 == 1 {
                self.offsets
                    .push(full + LONGEST as u32 + (kept_filter & !(u16::MAX << at)).count_ones());
            }
        }
        self.targets.resize(self.offsets.len(), target);
        self.vertices.resize(self.offsets.len(), entry.record);
    }

    /// Lets the records below `count` start where the lists end now, unless they have a start.
    fn start_records(&mut self, count: usize) {
        let [strips, writes, filter_changes] =
            [self.strips.len(), self.offsets.len(), self.filter_changes.len()].map(|n| n as u32);
        if self.starts.len() < count {
            self.starts.resize(count, Starts { strips, writes, filter_changes });
        }
    }

    /// Returns the changes of some records.
    pub(super) fn in_records(&self, records: &Range<u32>) -> UpdatesOfRecords<'_> {
        let [a, b] = [records.start, records.end].map(|k| self.starts[k as usize]);
        let writes = a.writes as usize..b.writes as usize;
        UpdatesOfRecords {
            strips: &self.strips[a.strips as usize..b.strips as usize],
            offsets: &self.offsets[writes.clone()],
            targets: &self.targets[writes.clone()],
            vertices: &self.vertices[writes],
            filter_changes: &self.filter_changes
                [a.filter_changes as usize..b.filter_changes as usize],
        }
    }
}

/// Returns the filter that draws a whole strip of a length.
pub(super) fn whole_strip(length: usize) -> u16 {
    u16::MAX >> (LONGEST - length)
}

/// All entries with their strips, by record, then strip (a counting sort).
fn by_record(histories: &Histories, records: usize) -> impl Iterator<Item = (u32, &Entry)> {
    let mut next_slots = vec![0u32; records + 1];
    for entry in &histories.entries {
        next_slots[entry.record as usize + 1] += 1;
    }
    for record in 0..records {
        next_slots[record + 1] += next_slots[record];
    }
    let mut order = vec![(0u32, 0u32); histories.entries.len()];
    for (strip, ends) in (0..).zip(histories.entry_starts.windows(2)) {
        for at in ends[0]..ends[1] {
            let slot = &mut next_slots[histories.entries[at as usize].record as usize];
            order[*slot as usize] = (strip, at);
            *slot += 1;
        }
    }
    order.into_iter().map(|(strip, at)| (strip, &histories.entries[at as usize]))
}
