//! The run-time arrays as the thesis (Ripollés 2009) has them in 3.3.2, with what overflows its
//! bytes spelled out.

use super::Speed;
use super::edits::Removed;
use crate::trace::{Removal, RemovalKind};
use lodc_mesh::Lod;

/// The byte that says "this or more: the number follows".
const ESCAPE: u8 = u8::MAX;

/// Added to the number of elements that go at an end of a strip.
pub const AT_END: i32 = 1 << 30;

/// One record. The vertex that it removes is its own number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LodInfo {
    /// The target of the removed vertex.
    pub vertex: u32,
    /// Number of strips it changes. 255: that many or more, and the number is the `strip` of a
    /// [`StripInfo`] that precedes those of the record.
    pub strips_affected: u8,
}

/// One strip that a record changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StripInfo {
    /// The strip.
    pub strip: u32,
    /// Number of operations that follow for it. 255: that many or more, and the number is a word
    /// before them. 0: with this record the strip dies.
    pub num_ops: u8,
}

/// The arrays of a model down to some LOD.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RunTime {
    /// One for each record.
    pub lods: Vec<LodInfo>,
    /// For each record the strips that it changes, in order.
    pub strips: Vec<StripInfo>,
    /// For each of these the operations, by their offset in the strip as it is before the record,
    /// where what was removed at its front before is still counted. `p ≥ 0`: the index at `p`
    /// changes. `p < 0`: elements from `!p` on (−1 is offset 0) go, and the next word is how many:
    /// `count` for a vertex repetition, `-count` for an edge repetition, `count + `[`AT_END`] for
    /// the back of the strip, `-count - `[`AT_END`] for its front. A change of an element that goes
    /// matters for refining only.
    pub updates: Vec<i32>,
}

/// One operation of [`RunTime::updates`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// The index at this offset becomes the record's target; backwards, the record's vertex.
    Change(u32),
    /// Elements go; backwards, they come again.
    Remove(Removal),
}

impl RunTime {
    pub(super) fn new(model: &Speed, lod: Lod) -> Self {
        let targets = model.simplified.collapses().targets();
        let mut arrays = Self::default();
        for record in 0..lod.0.min(targets.len() as u32) {
            let strips = model.edits.affected(&(record..record + 1));
            let affected = strips.len() as u32;
            if affected >= u32::from(ESCAPE) {
                arrays.strips.push(StripInfo { strip: affected, num_ops: 0 });
            }
            arrays.lods.push(LodInfo {
                vertex: targets[record as usize],
                strips_affected: byte(affected),
            });
            for (strip, operations) in strips.zip(model.operations(record)) {
                let count = operations.len() as u32;
                arrays.strips.push(StripInfo { strip, num_ops: byte(count) });
                if count >= u32::from(ESCAPE) {
                    arrays.updates.push(count as i32);
                }
                operations.into_iter().for_each(|operation| arrays.push(operation));
            }
        }
        arrays
    }

    fn push(&mut self, operation: Operation) {
        match operation {
            Operation::Change(offset) => self.updates.push(offset as i32),
            Operation::Remove(removal) => {
                self.updates.extend([!(removal.offset as i32), removal.word()]);
            }
        }
    }

    /// Reads the arrays back: for each record its strips with their operations, in order.
    #[must_use]
    pub fn records(&self) -> Vec<Vec<(u32, Vec<Operation>)>> {
        let (mut strips, mut updates) = (self.strips.iter(), self.updates.iter().copied());
        let mut next_strip = || *strips.next().expect("records and strips agree");
        let mut next_word = || updates.next().expect("strips and operations agree");
        let mut record = |lod: &LodInfo| {
            let escaped = lod.strips_affected == ESCAPE;
            let affected =
                if escaped { next_strip().strip } else { u32::from(lod.strips_affected) };
            let mut strip = || {
                let StripInfo { strip, num_ops } = next_strip();
                let count = if num_ops == ESCAPE { next_word() as u32 } else { u32::from(num_ops) };
                let mut operation = || match next_word() {
                    p if p >= 0 => Operation::Change(p as u32),
                    p => {
                        let word = next_word();
                        let (kind, count) = match (word > 0, word.abs() > AT_END) {
                            (true, false) => (RemovalKind::Vertex, word.abs()),
                            (false, false) => (RemovalKind::Edge, word.abs()),
                            (false, true) => (RemovalKind::Front, word.abs() - AT_END),
                            (true, true) => (RemovalKind::Back, word.abs() - AT_END),
                        };
                        Operation::Remove(Removal { offset: !p as u32, count: count as u32, kind })
                    }
                };
                (strip, (0..count).map(|_| operation()).collect())
            };
            (0..affected).map(|_| strip()).collect()
        };
        self.lods.iter().map(&mut record).collect()
    }

    /// Returns the bytes of the arrays as the thesis counts: a word and a byte for each record and
    /// each affected strip, a word for each change, two for each removal. What spells out an
    /// overflow is counted like the rest.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        5 * (self.lods.len() + self.strips.len()) as u64 + 4 * self.updates.len() as u64
    }
}

impl Removal {
    /// Returns the number of removed elements and the way in which they come back, in the word of
    /// [`RunTime::updates`].
    pub(super) fn word(self) -> i32 {
        let count = self.count as i32;
        match self.kind {
            RemovalKind::Vertex => count,
            RemovalKind::Edge => -count,
            RemovalKind::Front => -count - AT_END,
            RemovalKind::Back => count + AT_END,
        }
    }
}

/// The changes of a strip by one record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event<'a> {
    pub(super) strip: u32,
    /// The offsets in the buffer of all strips that change.
    pub(super) changes: &'a [u32],
    /// The removals, the last offset first.
    pub(super) removals: &'a [Removed],
}

impl Speed {
    /// Returns the changes of a record, strip by strip.
    pub(super) fn events(&self, record: u32) -> impl Iterator<Item = Event<'_>> {
        let record = record..record + 1;
        let run = self.edits.of(&record);
        let (mut changes, mut removals) = (run.offsets, run.removals);
        self.edits.affected(&record).map(move |strip| {
            let end = self.strips.range(strip as usize).end;
            let (changed, rest) =
                changes.split_at(changes.partition_point(|&p| (p as usize) < end));
            changes = rest;
            let (removed, rest) = removals.split_at(removals.partition_point(|g| g.strip <= strip));
            removals = rest;
            Event { strip, changes: changed, removals: removed }
        })
    }

    /// Returns the operations of a record on each strip that it changes, by offset.
    pub(super) fn operations(&self, record: u32) -> Vec<Vec<Operation>> {
        let of_strip = |event: Event<'_>| {
            let first = self.strips.range(event.strip as usize).start as u32;
            let removed = event.removals.iter().map(|g| Operation::Remove(g.removal));
            let changed = event.changes.iter().map(|p| Operation::Change(p - first));
            let mut operations: Vec<Operation> = removed.chain(changed).collect();
            // Stable: a removal comes before a change at the same offset.
            operations.sort_by_key(|operation| match operation {
                Operation::Change(offset) => *offset,
                Operation::Remove(removal) => removal.offset,
            });
            operations
        };
        self.events(record).map(of_strip).collect()
    }
}

fn byte(count: u32) -> u8 {
    u8::try_from(count).unwrap_or(ESCAPE)
}
