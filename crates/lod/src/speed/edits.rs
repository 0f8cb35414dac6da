//! All changes of all strips as they are kept at run time: in order of records, each strip's chained to its next.

use super::history::{History, Removal};
use std::ops::Range;

/// No entry.
pub(super) const NONE: u32 = u32::MAX;

/// One record's changes of one strip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) strip: u32,
    pub(super) record: u32,
    /// Where its changes start; they end where the next entry's start.
    first_change: u32,
    first_removal: u32,
    /// The strip's entry before this one, or [`NONE`].
    pub(super) previous: u32,
    /// The strip's entry after this one, or [`NONE`].
    pub(super) next: u32,
}

/// The list of changes, in order of records.
#[derive(Clone, Debug, Default)]
pub(super) struct Edits {
    /// Where each record's entries start, and where the last one's end.
    first: Vec<u32>,
    /// The entries, and one more at the end to say where the last one's changes end.
    entries: Vec<Entry>,
    changes: Vec<u32>,
    removals: Vec<Removal>,
    /// Each strip's first entry, or [`NONE`].
    head: Vec<u32>,
    /// For each index of the strips the first LOD without it.
    pub(super) removed_at: Vec<u32>,
    /// For each strip the first LOD at which it draws nothing.
    pub(super) deaths: Vec<u32>,
}

impl Edits {
    /// Puts histories of consecutive strips into the order of records (a counting sort: strips stay in order).
    pub(super) fn merge(histories: &[History], records: usize) -> Self {
        let mut first = vec![0u32; records + 1];
        let events = || histories.iter().flat_map(|h| &h.events);
        for event in events() {
            first[event.record as usize + 1] += 1;
        }
        for k in 0..records {
            first[k + 1] += first[k];
        }
        let count = first[records] as usize;
        let (mut place, mut order) = (first.clone(), vec![[0u32; 4]; count]);
        for (chunk, history) in histories.iter().enumerate() {
            // With each event where its changes and removals start in its history.
            let (mut change, mut removal) = (0, 0);
            for (i, event) in history.events.iter().enumerate() {
                let slot = &mut place[event.record as usize];
                order[*slot as usize] = [chunk as u32, i as u32, change, removal];
                *slot += 1;
                change += event.changes;
                removal += event.removals;
            }
        }
        let mut edits = Self { first, ..Self::default() };
        edits.entries.reserve_exact(count + 1);
        edits.changes.reserve_exact(histories.iter().map(|h| h.changes.len()).sum());
        edits.removals.reserve_exact(histories.iter().map(|h| h.removals.len()).sum());
        for [chunk, i, change, removal] in order {
            let history = &histories[chunk as usize];
            let event = history.events[i as usize];
            edits.entries.push(edits.entry(event.strip, event.record));
            edits.changes.extend_from_slice(&history.changes[change as usize..][..event.changes as usize]);
            edits.removals.extend_from_slice(&history.removals[removal as usize..][..event.removals as usize]);
        }
        edits.entries.push(edits.entry(NONE, records as u32));
        edits.removed_at = histories.iter().flat_map(|h| &h.removed_at).copied().collect();
        edits.deaths = histories.iter().flat_map(|h| &h.deaths).copied().collect();
        edits.chain();
        edits
    }

    fn entry(&self, strip: u32, record: u32) -> Entry {
        let (first_change, first_removal) = (self.changes.len() as u32, self.removals.len() as u32);
        Entry { strip, record, first_change, first_removal, previous: NONE, next: NONE }
    }

    fn chain(&mut self) {
        let mut latest = vec![NONE; self.deaths.len()];
        self.head = latest.clone();
        for e in 0..self.entries.len() - 1 {
            let before = std::mem::replace(&mut latest[self.entries[e].strip as usize], e as u32);
            self.entries[e].previous = before;
            if before == NONE {
                self.head[self.entries[e].strip as usize] = e as u32;
            } else {
                self.entries[before as usize].next = e as u32;
            }
        }
    }

    /// The entries of some records.
    pub(super) fn of_records(&self, records: Range<u32>) -> Range<u32> {
        self.first[records.start as usize]..self.first[records.end as usize]
    }
    pub(super) fn get(&self, entry: u32) -> Entry {
        self.entries[entry as usize]
    }
    /// Places that change.
    pub(super) fn changes(&self, entry: u32) -> &[u32] {
        let [a, b] = [entry, entry + 1].map(|e| self.entries[e as usize].first_change as usize);
        &self.changes[a..b]
    }
    /// A strip's entries, in order of records.
    pub(super) fn of_strip(&self, strip: usize) -> impl Iterator<Item = u32> {
        let known = |entry: u32| (entry != NONE).then_some(entry);
        std::iter::successors(known(self.head[strip]), move |&entry| known(self.entries[entry as usize].next))
    }
    /// All removals of a strip, each with the number of the strip's entry that makes it.
    pub(super) fn removals_of(&self, strip: usize) -> Vec<(u32, Removal)> {
        let mut all = Vec::new();
        let (mut entry, mut number) = (self.head[strip], 0);
        while entry != NONE {
            all.extend(self.removals(entry).iter().map(|&r| (number, r)));
            (entry, number) = (self.get(entry).next, number + 1);
        }
        all
    }
    /// Repetitions that go.
    pub(super) fn removals(&self, entry: u32) -> &[Removal] {
        let [a, b] = [entry, entry + 1].map(|e| self.entries[e as usize].first_removal as usize);
        &self.removals[a..b]
    }
}
