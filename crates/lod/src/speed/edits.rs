//! All changes of all strips as they are kept at run time: in order of records, ready to be
//! streamed.
//!
//! Strips stand one behind the other in one buffer and keep their room when they get shorter, so an
//! index change needs no strip: it is a place in the buffer and what to write there. Whatever a
//! move needs is a few runs of such lists, without a look at single records.

use crate::trace::{History, Removal};
use lodc_strip::StripSet;
use std::ops::Range;

/// Where a record's entries start in each of the lists; they end where the next record's start.
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
    /// Its entry before this one and after it; `u32::MAX` for none.
    previous: u32,
    next: u32,
    /// How long it is before and after the record, 0 if it is dead.
    before: u32,
    after: u32,
}

/// Elements that go.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gone {
    pub(super) strip: u32,
    pub(super) record: u32,
    pub(super) removal: Removal,
    /// How many changes, of all records, come before it.
    pub(super) changes: u32,
}

/// The lists of changes.
#[derive(Clone, Debug, Default)]
pub(super) struct Edits {
    /// One for each record, and one more.
    starts: Vec<Starts>,
    /// By record, then strip.
    affected: Vec<Affected>,
    /// The places of the buffer that change, by record, then place.
    places: Vec<u32>,
    /// What each of them becomes.
    targets: Vec<u32>,
    /// What each of them was: the vertex that the record removes.
    vertices: Vec<u32>,
    /// By record, then strip, the last place first: so that one does not move the next.
    removals: Vec<Gone>,
    /// The strips that die, by record.
    dying: Vec<u32>,
    /// For each index of the strips the first LOD without it.
    pub(super) removed_at: Vec<u32>,
    /// For each index whether it goes at the front of its strip.
    at_front: Vec<bool>,
    /// For each index that goes at an end of its strip its place then; for others `u32::MAX`.
    pub(super) left_at: Vec<u32>,
    /// For each strip the first LOD at which it draws nothing.
    pub(super) removal_lods: Vec<u32>,
}

/// What some consecutive records do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run<'a> {
    /// How many changes come before the first of these.
    pub(super) first_change: u32,
    pub(super) places: &'a [u32],
    pub(super) targets: &'a [u32],
    pub(super) vertices: &'a [u32],
    pub(super) removals: &'a [Gone],
    pub(super) dying: &'a [u32],
}

impl Edits {
    /// Puts histories of consecutive strips into the order of records (a counting sort: strips stay
    /// in order).
    pub(super) fn merge(histories: &[History], strips: &StripSet, targets: &[u32]) -> Self {
        let records = targets.len();
        let mut place = vec![0u32; records + 1];
        for event in histories.iter().flat_map(|h| &h.events) {
            place[event.record as usize + 1] += 1;
        }
        for k in 0..records {
            place[k + 1] += place[k];
        }
        // Where each event is, and where its changes and removals start in its history.
        let mut order = vec![[0u32; 4]; place[records] as usize];
        for (chunk, history) in histories.iter().enumerate() {
            let (mut change, mut removal) = (0, 0);
            for (i, event) in history.events.iter().enumerate() {
                let slot = &mut place[event.record as usize];
                order[*slot as usize] = [chunk as u32, i as u32, change, removal];
                *slot += 1;
                change += event.changes;
                removal += event.removals;
            }
        }
        let mut edits = Self { starts: Vec::with_capacity(records + 1), ..Self::default() };
        let changes = histories.iter().map(|h| h.changes.len()).sum();
        edits.affected.reserve_exact(order.len());
        edits.places.reserve_exact(changes);
        edits.targets.reserve_exact(changes);
        edits.vertices.reserve_exact(changes);
        edits.removals.reserve_exact(histories.iter().map(|h| h.removals.len()).sum());
        // The latest entry of each strip, and its length.
        let mut latest = vec![u32::MAX; strips.len()];
        let mut length: Vec<u32> = strips.iter().map(|s| s.len() as u32).collect();
        for [chunk, i, change, removal] in order {
            let history = &histories[chunk as usize];
            let event = history.events[i as usize];
            edits.start_records(event.record as usize + 1);
            let places = &history.changes[change as usize..][..event.changes as usize];
            let removals = &history.removals[removal as usize..][..event.removals as usize];
            let first = strips.range(event.strip as usize).start as u32;
            edits.places.extend(places.iter().map(|p| first + p));
            edits.targets.resize(edits.places.len(), targets[event.record as usize]);
            edits.vertices.resize(edits.places.len(), event.record);
            let (strip, record, changes) = (event.strip, event.record, edits.places.len() as u32);
            let gone = |&removal| Gone { strip, record, removal, changes };
            edits.removals.extend(removals.iter().rev().map(gone));
            let (entry, before) = (edits.affected.len() as u32, length[event.strip as usize]);
            let previous = std::mem::replace(&mut latest[event.strip as usize], entry);
            let after = if places.is_empty() {
                0
            } else {
                before - removals.iter().map(|r| r.count).sum::<u32>()
            };
            length[event.strip as usize] = after;
            edits.affected.push(Affected {
                strip: event.strip,
                previous,
                next: u32::MAX,
                before,
                after,
            });
            if let Some(previous) = edits.affected.get_mut(previous as usize) {
                previous.next = entry;
            }
            if places.is_empty() {
                edits.dying.push(event.strip);
            }
        }
        edits.start_records(records + 1);
        edits.removed_at = histories.iter().flat_map(|h| &h.removed_at).copied().collect();
        edits.at_front = histories.iter().flat_map(|h| &h.at_front).copied().collect();
        edits.left_at = histories.iter().flat_map(|h| &h.left_at).copied().collect();
        edits.removal_lods = histories.iter().flat_map(|h| &h.removal_lods).copied().collect();
        edits
    }

    /// Records up to a number start where the lists end now, unless they have started before.
    fn start_records(&mut self, count: usize) {
        let starts = Starts {
            affected: self.affected.len() as u32,
            changes: self.places.len() as u32,
            removals: self.removals.len() as u32,
            dying: self.dying.len() as u32,
        };
        if self.starts.len() < count {
            self.starts.resize(count, starts);
        }
    }

    /// How many records there are.
    pub(super) fn records(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// What some records do.
    pub(super) fn of(&self, records: &Range<u32>) -> Run<'_> {
        let [a, b] = [records.start, records.end].map(|k| self.starts[k as usize]);
        let changes = a.changes as usize..b.changes as usize;
        Run {
            first_change: a.changes,
            places: &self.places[changes.clone()],
            targets: &self.targets[changes.clone()],
            vertices: &self.vertices[changes],
            removals: &self.removals[a.removals as usize..b.removals as usize],
            dying: &self.dying[a.dying as usize..b.dying as usize],
        }
    }

    /// How many elements have gone at the front of a strip, given its room, at a LOD.
    pub(super) fn gone_at_front(&self, room: Range<usize>, lod: u32) -> usize {
        let removed = self.removed_at[room.clone()].iter().zip(&self.at_front[room]);
        removed.take_while(|(at, _)| **at <= lod).filter(|(_, front)| **front).count()
    }

    /// Whether an index goes at the front of its strip.
    pub(super) fn at_front(&self, index: usize) -> bool {
        self.at_front[index]
    }

    fn entries(&self, records: &Range<u32>) -> Range<u32> {
        self.starts[records.start as usize].affected..self.starts[records.end as usize].affected
    }
    /// How often some records change a strip.
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
    /// How many elements the strips that some records change have together, before them or after
    /// them. Each counts once: with its first or last entry among these.
    pub(super) fn elements(&self, records: &Range<u32>, after: bool) -> u64 {
        let range = self.entries(records);
        let entries = &self.affected[range.start as usize..range.end as usize];
        let counts = entries.iter().map(|e| match after {
            true if e.next >= range.end => e.after,
            false if e.previous == u32::MAX || e.previous < range.start => e.before,
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
            for gone in self.of(&record).removals.iter().rev() {
                by_strip[gone.strip as usize].push((events[gone.strip as usize], gone.removal));
            }
            for strip in self.affected(&record) {
                events[strip as usize] += 1;
            }
        }
        by_strip
    }
}
