//! All changes of all strips as they are kept at run time: in order of records, ready to be streamed.
//!
//! Strips stand one behind the other in one buffer and keep their room when they get shorter, so an index change needs no
//! strip: it names the place in the buffer.

use super::history::{History, Removal};
use lodc_strip::StripSet;
use std::ops::Range;

/// Where a record's changes start in each of the lists; they end where the next record's start.
#[derive(Clone, Copy, Debug, Default)]
struct Starts {
    affected: u32,
    changes: u32,
    removals: u32,
    dying: u32,
}

/// The lists of changes.
#[derive(Clone, Debug, Default)]
pub(super) struct Edits {
    /// One for each record, and one more.
    starts: Vec<Starts>,
    /// The strips that a record changes, rising.
    affected: Vec<u32>,
    /// The places of the buffer that become the record's target.
    changes: Vec<u32>,
    /// The repetitions that go, by strip and place, each with its strip.
    removals: Vec<(u32, Removal)>,
    /// The strips that die.
    dying: Vec<u32>,
    /// For each index of the strips the first LOD without it.
    pub(super) removed_at: Vec<u32>,
    /// For each strip the first LOD at which it draws nothing.
    pub(super) deaths: Vec<u32>,
}

impl Edits {
    /// Puts histories of consecutive strips into the order of records (a counting sort: strips stay in order).
    pub(super) fn merge(histories: &[History], strips: &StripSet, records: usize) -> Self {
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
        edits.affected.reserve_exact(order.len());
        edits.changes.reserve_exact(histories.iter().map(|h| h.changes.len()).sum());
        edits.removals.reserve_exact(histories.iter().map(|h| h.removals.len()).sum());
        for [chunk, i, change, removal] in order {
            let history = &histories[chunk as usize];
            let event = history.events[i as usize];
            edits.start_records(event.record as usize + 1);
            edits.affected.push(event.strip);
            let first = strips.range(event.strip as usize).start as u32;
            let changes = &history.changes[change as usize..][..event.changes as usize];
            edits.changes.extend(changes.iter().map(|p| first + p));
            let removals = &history.removals[removal as usize..][..event.removals as usize];
            edits.removals.extend(removals.iter().map(|&r| (event.strip, r)));
            if event.changes == 0 {
                edits.dying.push(event.strip);
            }
        }
        edits.start_records(records + 1);
        edits.removed_at = histories.iter().flat_map(|h| &h.removed_at).copied().collect();
        edits.deaths = histories.iter().flat_map(|h| &h.deaths).copied().collect();
        edits
    }

    /// Records up to a number start where the lists end now, unless they have started before.
    fn start_records(&mut self, count: usize) {
        let starts = Starts {
            affected: self.affected.len() as u32,
            changes: self.changes.len() as u32,
            removals: self.removals.len() as u32,
            dying: self.dying.len() as u32,
        };
        if self.starts.len() < count {
            self.starts.resize(count, starts);
        }
    }

    /// The strips that some records change: each as often as there are records that do.
    pub(super) fn affected(&self, records: Range<u32>) -> &[u32] {
        let [a, b] = [records.start, records.end].map(|k| self.starts[k as usize].affected as usize);
        &self.affected[a..b]
    }
    /// The places of the buffer that a record changes.
    pub(super) fn changes(&self, record: u32) -> &[u32] {
        let [a, b] = [record, record + 1].map(|k| self.starts[k as usize].changes as usize);
        &self.changes[a..b]
    }
    /// The repetitions that a record takes out.
    pub(super) fn removals(&self, record: u32) -> &[(u32, Removal)] {
        let [a, b] = [record, record + 1].map(|k| self.starts[k as usize].removals as usize);
        &self.removals[a..b]
    }
    /// The strips that die with a record.
    pub(super) fn dying(&self, record: u32) -> &[u32] {
        let [a, b] = [record, record + 1].map(|k| self.starts[k as usize].dying as usize);
        &self.dying[a..b]
    }
    /// How many records there are.
    pub(super) fn records(&self) -> u32 {
        self.starts.len() as u32 - 1
    }

    /// For each strip its removals, each with the number of the event that makes it among those of the strip.
    pub(super) fn removals_by_strip(&self) -> Vec<Vec<(u32, Removal)>> {
        let mut by_strip = vec![Vec::new(); self.deaths.len()];
        let mut events = vec![0u32; self.deaths.len()];
        for record in 0..self.records() {
            for &(strip, removal) in self.removals(record) {
                by_strip[strip as usize].push((events[strip as usize], removal));
            }
            for &strip in self.affected(record..record + 1) {
                events[strip as usize] += 1;
            }
        }
        by_strip
    }
}
