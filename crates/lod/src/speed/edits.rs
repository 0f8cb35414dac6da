//! All changes of all strips as they are kept at run time: in order of records, ready to be
//! applied.
//!
//! Strips follow one another in one buffer and keep their part of it when they get shorter, so an
//! index change needs no strip: it is an offset in the buffer and what to write there. A move reads
//! a few consecutive parts of such lists, and no single records.

use crate::trace::{History, Removal};
use lodc_mesh::NONE;
use lodc_strip::StripSet;
use std::ops::Range;

/// Start of a record's entries in each of the lists; they end where the next record's start.
#[derive(Clone, Copy, Debug, Default)]
struct Starts {
    affected: u32,
    changes: u32,
    removals: u32,
    dying: u32,
}

/// A strip that a record changes.
#[derive(Clone, Copy, Debug)]
struct Affected {
    strip: u32,
    /// Its entry before this one and after it; [`NONE`] for none.
    previous: u32,
    next: u32,
    /// Its length before and after the record, 0 if it is dead.
    length_before: u32,
    length_after: u32,
}

/// Removed elements.
#[derive(Clone, Copy, Debug)]
pub(super) struct Removed {
    pub(super) strip: u32,
    pub(super) record: u32,
    pub(super) removal: Removal,
    /// Number of changes, of all records, before it.
    pub(super) changes_before: u32,
}

/// The lists of changes.
#[derive(Clone, Debug, Default)]
pub(super) struct Edits {
    /// One for each record, and one more.
    starts: Vec<Starts>,
    /// By record, then strip.
    affected: Vec<Affected>,
    /// The offsets in the buffer that change, by record, then offset.
    offsets: Vec<u32>,
    /// The target of each of them.
    targets: Vec<u32>,
    /// The vertex that the record removes, which each of them was.
    vertices: Vec<u32>,
    /// By record, then strip, the last offset first: so that one does not move the next.
    removals: Vec<Removed>,
    /// The strips that die, by record.
    dying: Vec<u32>,
    /// For each index of the strips the first LOD without it.
    pub(super) index_removal_lods: Vec<u32>,
    /// For each index whether it is removed at the front of its strip.
    is_removed_at_front: Vec<bool>,
    /// For each index that is removed at an end of its strip its offset in the strip then; for
    /// others [`NONE`].
    pub(super) end_offsets: Vec<u32>,
    /// For each strip the first LOD at which it draws nothing.
    pub(super) removal_lods: Vec<u32>,
}

/// The changes of some consecutive records.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run<'a> {
    /// Number of changes before the first of these.
    pub(super) first_change: u32,
    pub(super) offsets: &'a [u32],
    pub(super) targets: &'a [u32],
    pub(super) vertices: &'a [u32],
    pub(super) removals: &'a [Removed],
    pub(super) dying: &'a [u32],
}

/// The latest entry of each strip in [`Edits::affected`], and its length after it.
struct Latest {
    entry: Vec<u32>,
    length: Vec<u32>,
}

impl Latest {
    fn new(strips: &StripSet) -> Self {
        let length = strips.iter().map(|s| s.len() as u32).collect();
        Self { entry: vec![NONE; strips.len()], length }
    }
}

/// Where an event is stored: its history, its number there, and where its changes and removals
/// start.
#[derive(Clone, Copy, Default)]
struct EventLocation {
    history: u32,
    event: u32,
    change: u32,
    removal: u32,
}

/// The changes and removals of one strip by one record. Without changes the strip dies.
struct Update<'a> {
    strip: u32,
    record: u32,
    offsets: &'a [u32],
    removals: &'a [Removal],
}

impl<'a> Update<'a> {
    fn new(history: &'a History, location: &EventLocation) -> Self {
        let event = history.events[location.event as usize];
        Self {
            strip: event.strip,
            record: event.record,
            offsets: &history.changes[location.change as usize..][..event.changes as usize],
            removals: &history.removals[location.removal as usize..][..event.removals as usize],
        }
    }
}

/// All events in order of records, and within a record of strips (a counting sort).
fn by_record(histories: &[History], records: usize) -> Vec<EventLocation> {
    let mut next_slot = vec![0u32; records + 1];
    for event in histories.iter().flat_map(|h| &h.events) {
        next_slot[event.record as usize + 1] += 1;
    }
    for k in 0..records {
        next_slot[k + 1] += next_slot[k];
    }
    let mut order = vec![EventLocation::default(); next_slot[records] as usize];
    for (number, history) in histories.iter().enumerate() {
        let mut location = EventLocation { history: number as u32, ..EventLocation::default() };
        for event in &history.events {
            let slot = &mut next_slot[event.record as usize];
            order[*slot as usize] = location;
            *slot += 1;
            location.event += 1;
            location.change += event.changes;
            location.removal += event.removals;
        }
    }
    order
}

impl Edits {
    /// Share of the records after which the length of a strip is another one.
    pub(super) fn length_changes(&self) -> f64 {
        let of_record =
            |pair: &&[Starts]| &self.affected[pair[0].affected as usize..pair[1].affected as usize];
        let changes =
            |pair: &&[Starts]| of_record(pair).iter().any(|a| a.length_before != a.length_after);
        let records = self.starts.windows(2);
        let count = records.len().max(1);
        records.filter(changes).count() as f64 / count as f64
    }

    /// Puts histories of consecutive strips into the order of records (a counting sort: strips stay
    /// in order).
    pub(super) fn merge(histories: &[History], strips: &StripSet, targets: &[u32]) -> Self {
        let mut edits = Self { starts: Vec::with_capacity(targets.len() + 1), ..Self::default() };
        let changes = histories.iter().map(|h| h.changes.len()).sum();
        edits.affected.reserve_exact(histories.iter().map(|h| h.events.len()).sum());
        edits.offsets.reserve_exact(changes);
        edits.targets.reserve_exact(changes);
        edits.vertices.reserve_exact(changes);
        edits.removals.reserve_exact(histories.iter().map(|h| h.removals.len()).sum());
        let mut latest = Latest::new(strips);
        for location in by_record(histories, targets.len()) {
            let update = Update::new(&histories[location.history as usize], &location);
            edits.start_records(update.record as usize + 1);
            let room = strips.range(update.strip as usize).start as u32;
            edits.push(&update, room, targets[update.record as usize]);
            edits.affect(&update, &mut latest);
        }
        edits.start_records(targets.len() + 1);
        edits.index_removal_lods =
            histories.iter().flat_map(|h| &h.index_removal_lods).copied().collect();
        edits.is_removed_at_front =
            histories.iter().flat_map(|h| &h.is_removed_at_front).copied().collect();
        edits.end_offsets = histories.iter().flat_map(|h| &h.end_offsets).copied().collect();
        edits.removal_lods = histories.iter().flat_map(|h| &h.removal_lods).copied().collect();
        edits
    }

    /// Adds the changes and removals of a strip whose room starts at `room`.
    fn push(&mut self, update: &Update<'_>, room: u32, target: u32) {
        self.offsets.extend(update.offsets.iter().map(|p| room + p));
        self.targets.resize(self.offsets.len(), target);
        self.vertices.resize(self.offsets.len(), update.record);
        let (strip, record, changes_before) =
            (update.strip, update.record, self.offsets.len() as u32);
        let removed = |&removal| Removed { strip, record, removal, changes_before };
        self.removals.extend(update.removals.iter().rev().map(removed));
    }

    /// Adds the entry of the strip itself.
    fn affect(&mut self, update: &Update<'_>, latest: &mut Latest) {
        let (strip, entry) = (update.strip as usize, self.affected.len() as u32);
        let previous = std::mem::replace(&mut latest.entry[strip], entry);
        let length_before = latest.length[strip];
        let removed: u32 = update.removals.iter().map(|r| r.count).sum();
        let length_after = if update.offsets.is_empty() { 0 } else { length_before - removed };
        latest.length[strip] = length_after;
        self.affected.push(Affected {
            strip: update.strip,
            previous,
            next: NONE,
            length_before,
            length_after,
        });
        if let Some(previous) = self.affected.get_mut(previous as usize) {
            previous.next = entry;
        }
        if update.offsets.is_empty() {
            self.dying.push(update.strip);
        }
    }

    /// Records up to a number start where the lists end now, unless they have started before.
    fn start_records(&mut self, count: usize) {
        let starts = Starts {
            affected: self.affected.len() as u32,
            changes: self.offsets.len() as u32,
            removals: self.removals.len() as u32,
            dying: self.dying.len() as u32,
        };
        if self.starts.len() < count {
            self.starts.resize(count, starts);
        }
    }

    /// Returns the number of records.
    pub(super) fn records(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// Returns the changes of some records.
    pub(super) fn of(&self, records: &Range<u32>) -> Run<'_> {
        let [a, b] = [records.start, records.end].map(|k| self.starts[k as usize]);
        let changes = a.changes as usize..b.changes as usize;
        Run {
            first_change: a.changes,
            offsets: &self.offsets[changes.clone()],
            targets: &self.targets[changes.clone()],
            vertices: &self.vertices[changes],
            removals: &self.removals[a.removals as usize..b.removals as usize],
            dying: &self.dying[a.dying as usize..b.dying as usize],
        }
    }

    /// Returns the number of elements removed at the front of a strip, given its room, at a LOD.
    pub(super) fn removed_at_front(&self, room: Range<usize>, lod: u32) -> usize {
        let removed =
            self.index_removal_lods[room.clone()].iter().zip(&self.is_removed_at_front[room]);
        removed.take_while(|(at, _)| **at <= lod).filter(|(_, front)| **front).count()
    }

    /// Returns whether an index is removed at the front of its strip.
    pub(super) fn is_removed_at_front(&self, index: usize) -> bool {
        self.is_removed_at_front[index]
    }

    fn entries(&self, records: &Range<u32>) -> Range<u32> {
        self.starts[records.start as usize].affected..self.starts[records.end as usize].affected
    }
    /// Counts how often some records change a strip.
    pub(super) fn visits(&self, records: &Range<u32>) -> u32 {
        self.entries(records).len() as u32
    }
    /// The strips that some records change, by record: each as often as there are records that do.
    pub(super) fn affected<'a>(
        &'a self,
        records: &Range<u32>,
    ) -> impl ExactSizeIterator<Item = u32> + use<'a> {
        let entries = self.entries(records);
        self.affected[entries.start as usize..entries.end as usize].iter().map(|e| e.strip)
    }
    /// Returns the number of elements of all strips that some records change, before
    /// them or after them. Each counts once: with its first or last entry among these.
    pub(super) fn elements(&self, records: &Range<u32>, after: bool) -> u64 {
        let range = self.entries(records);
        let entries = &self.affected[range.start as usize..range.end as usize];
        let counts = entries.iter().map(|e| match after {
            true if e.next >= range.end => e.length_after,
            false if e.previous == NONE || e.previous < range.start => e.length_before,
            _ => 0,
        });
        counts.map(u64::from).sum()
    }

    /// For each strip its removals, each with the number of the event that makes it among those of
    /// the strip.
    pub(super) fn removals_by_strip(&self) -> Vec<Vec<(u32, Removal)>> {
        let mut by_strip = vec![Vec::new(); self.removal_lods.len()];
        let mut events = vec![0u32; self.removal_lods.len()];
        for record in 0..self.records() {
            let record = record..record + 1;
            for removed in self.of(&record).removals.iter().rev() {
                by_strip[removed.strip as usize]
                    .push((events[removed.strip as usize], removed.removal));
            }
            for strip in self.affected(&record) {
                events[strip as usize] += 1;
            }
        }
        by_strip
    }
}
