//! The array in which Speed Strips store their removals, and the replay that checks them as it is
//! read. Index changes are not stored: they follow from strips and sequence.
//!
//! For each strip in turn the number of its removals (varint), then for each removal three varints:
//! how many of the strip's events (records that change it while it is live) lie between it and the
//! event of the one before, or the start; its offset before that event ([`Removal::offset`]); and
//! four times how many elements are removed, plus the number of their [`RemovalKind`].

use crate::trace::{Removal, RemovalKind, RemovalSource, RemovedRun, WorkingStrip};
use lodc_mesh::put_leb128;
use lodc_model::bytes::Reader;
use lodc_model::{Array, BuildError};

/// Name of the array.
pub(super) const REMOVALS: &str = "removals";

/// The removals of all strips as an array.
pub(super) fn to_array(by_strip: &[Vec<(u32, Removal)>]) -> Array {
    let mut bytes = Vec::new();
    for removals in by_strip {
        put_leb128(&mut bytes, removals.len() as u64);
        let mut latest = 0;
        for &(event, removal) in removals {
            put_leb128(&mut bytes, u64::from(event - latest));
            put_leb128(&mut bytes, u64::from(removal.offset));
            put_leb128(&mut bytes, u64::from(4 * removal.count + removal.kind as u32));
            latest = event;
        }
    }
    Array { name: REMOVALS.to_owned(), bytes, wide: false }
}

/// Removals as read: for each strip those of its own.
pub(super) struct Stored {
    /// Start of each strip's removals in `removals`, and end of the last one's.
    first: Vec<u32>,
    removals: Vec<(u32, Removal)>,
}

impl Stored {
    /// Reads the array of a number of strips. Whether removals fit their strips is for
    /// [`CheckedRemovals`] to find.
    pub(super) fn read(array: &Array, strips: usize) -> Result<Self, BuildError> {
        if array.wide {
            return Err(wrong("is never written wide"));
        }
        let mut reader = Reader::new(&array.bytes);
        let short = || wrong("ends early or has a malformed number");
        if strips > reader.remaining() {
            return Err(short());
        }
        let mut stored = Self { first: Vec::with_capacity(strips + 1), removals: Vec::new() };
        for _ in 0..strips {
            stored.first.push(stored.removals.len() as u32);
            let mut event = 0u32;
            for _ in 0..reader.varint().ok_or_else(short)? {
                event = reader.varint().and_then(|n| event.checked_add(n)).ok_or_else(short)?;
                let offset = reader.varint().ok_or_else(short)?;
                let code = reader.varint().ok_or_else(short)?;
                let (count, kind) = (code / 4, RemovalKind::ALL[code as usize % 4]);
                if count == 0 {
                    return Err(wrong("has a removal of no element"));
                }
                stored.removals.push((event, Removal { offset, count, kind }));
            }
        }
        stored.first.push(stored.removals.len() as u32);
        if reader.remaining() > 0 {
            Err(wrong("is longer than its strips need"))
        } else {
            Ok(stored)
        }
    }

    /// The removals of one strip.
    pub(super) fn of(&self, strip: usize) -> &[(u32, Removal)] {
        &self.removals[self.first[strip] as usize..self.first[strip + 1] as usize]
    }
}

/// Applies the stored removals of one strip.
pub(super) struct CheckedRemovals<'a> {
    pending: &'a [(u32, Removal)],
    event: u32,
    removed_runs: Vec<RemovedRun>,
}

impl<'a> CheckedRemovals<'a> {
    pub(super) fn new(removals: &'a [(u32, Removal)]) -> Self {
        Self { pending: removals, event: 0, removed_runs: Vec::new() }
    }
    /// Fails if removals are left over.
    pub(super) fn finish(self) -> Result<(), BuildError> {
        if self.pending.is_empty() {
            Ok(())
        } else {
            Err(wrong("has removals of a strip that is dead"))
        }
    }
}

impl RemovalSource for CheckedRemovals<'_> {
    const NEEDS_LAST_RECORD: bool = false;

    fn next_removals(
        &mut self,
        strip: &mut WorkingStrip,
        _: &[u32],
    ) -> Result<&[RemovedRun], BuildError> {
        let count = self.pending.iter().take_while(|(event, _)| *event == self.event).count();
        let (due, pending) = self.pending.split_at(count);
        (self.pending, self.event) = (pending, self.event + 1);
        self.removed_runs.clear();
        let mut free_from = 0;
        for (_, removal) in due {
            let (kind, period) = (removal.kind, removal.kind.period());
            if removal.offset.checked_sub(period).is_none_or(|start| start < free_from) {
                return Err(wrong("has removals out of order or resting on one another"));
            }
            let first = strip
                .element_at(removal.offset)
                .ok_or_else(|| wrong("removes what is not there"))?;
            let (mut last, mut element) = (first, first);
            for _ in 0..removal.count {
                if !strip.is_inside(element) || period > 0 && !strip.repeats(element, period) {
                    return Err(wrong("removes what is not there or no repetition"));
                }
                (last, element) = (element, strip.next(element));
            }
            let dead = match kind {
                RemovalKind::Vertex | RemovalKind::Edge => true,
                RemovalKind::Front => first == strip.front() && last < strip.first_drawn(),
                RemovalKind::Back => last == strip.back() && first > strip.last_corner(),
            };
            if !dead {
                return Err(wrong("removes a drawn triangle, or from the middle as from an end"));
            }
            free_from = removal.offset + removal.count;
            self.removed_runs.push(RemovedRun { first, last, count: removal.count, kind });
        }
        for run in &self.removed_runs {
            match run.kind {
                RemovalKind::Vertex | RemovalKind::Edge => {
                    strip.unlink_repetition(run.first, run.last);
                }
                RemovalKind::Front | RemovalKind::Back => strip.unlink(run.first, run.last),
            }
        }
        Ok(&self.removed_runs)
    }
}

fn wrong(what: &str) -> BuildError {
    BuildError::Malformed { array: REMOVALS, what: what.to_owned() }
}
