//! Traces one strip through the records that change it, with a queue of its vertices by the record
//! at which each disappears.

use super::history::{Event, History, Removal, RemovalKind};
use super::working::{RemovedRun, WorkingStrip};
use crate::stored_strips::STRIPS;
use lodc_mesh::{NONE, PositionIds};
use lodc_model::BuildError;
use lodc_strip::StripSet;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

/// Changes that a strip may have for each index: strips of real meshes have about five, and a file
/// may claim any number. Chosen by hand.
const MAX_CHANGES_PER_INDEX: usize = 300;

/// The strips that are traced, and the sequence.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TraceInput<'a> {
    /// The collapse target of each record.
    pub(crate) targets: &'a [u32],
    pub(crate) strips: &'a StripSet,
    pub(crate) positions: &'a PositionIds,
}

/// Says which elements each record removes from a strip: a filter chooses them, or a file has them.
pub(crate) trait RemovalSource {
    /// True if [`Self::begin_strip`] has to be called: finding the last record costs a trace.
    const NEEDS_LAST_RECORD: bool;
    /// Begins a strip that dies with a record.
    fn begin_strip(&mut self, _last_record: u32) {}
    /// Returns the elements that the next record of the strip removes, and unlinks them. `changed`
    /// are the elements that the record has changed.
    ///
    /// # Errors
    /// If what is stored does not fit the strip.
    fn next_removals(
        &mut self,
        strip: &mut WorkingStrip,
        changed: &[u32],
    ) -> Result<&[RemovedRun], BuildError>;
}

/// Works on runs of strips in parallel. The runs depend on the strips alone.
///
/// # Errors
/// As `work`.
pub(crate) fn in_parallel<T: Send>(
    input: &TraceInput<'_>,
    work: impl Fn(&mut StripTracer, Range<usize>) -> Result<T, BuildError> + Sync,
) -> Result<Vec<T>, BuildError> {
    // Few enough that all threads have runs on meshes of tens of thousands of triangles. Chosen by
    // hand.
    const INDICES_PER_RUN: usize = 1 << 14;
    let strips = input.strips;
    let (mut runs, mut first, mut indices) = (Vec::new(), 0, 0);
    for (i, strip) in strips.iter().enumerate() {
        indices += strip.len();
        if indices >= INDICES_PER_RUN || i + 1 == strips.len() {
            runs.push(first..i + 1);
            (first, indices) = (i + 1, 0);
        }
    }
    runs.into_par_iter().map_init(StripTracer::default, |tracer, run| work(tracer, run)).collect()
}

/// Follows strips through the records that change them; used for many strips, to allocate once.
#[derive(Debug, Default)]
pub(crate) struct StripTracer {
    strip: WorkingStrip,
    /// Vertices with the elements that hold them, the next to disappear first.
    queue: BinaryHeap<Reverse<(u32, u32)>>,
    /// The elements that the latest record changed.
    changed: Vec<u32>,
}

/// The next vertex of a strip to disappear.
struct Collapse {
    record: u32,
    /// False for the last vertex of all, which never disappears.
    happens: bool,
}

impl StripTracer {
    /// Traces some strips.
    ///
    /// # Errors
    /// If `removals` fails, or strips change more often than those of any real mesh.
    pub(crate) fn trace(
        &mut self,
        input: &TraceInput<'_>,
        range: Range<usize>,
        removals: &mut impl RemovalSource,
    ) -> Result<History, BuildError> {
        let mut history = History::default();
        for strip in range {
            self.trace_strip(input, strip, removals, &mut history)?;
        }
        Ok(history)
    }

    fn trace_strip<R: RemovalSource>(
        &mut self,
        input: &TraceInput<'_>,
        id: usize,
        removals: &mut R,
        history: &mut History,
    ) -> Result<(), BuildError> {
        let strip = input.strips.strip(id);
        if R::NEEDS_LAST_RECORD {
            removals.begin_strip(self.last_record(input, strip));
        }
        let max_changes = history.changes.len() + max_changes(strip);
        let first_index = history.begin_strip(strip.len());
        self.start(strip, input.positions);
        let mut removal_lod = 0;
        while self.strip.is_live() {
            let Collapse { record, happens } = self.collapse_next(input);
            if !happens {
                removal_lod = NONE;
                break;
            }
            removal_lod = record + 1;
            let mut event = Event { strip: id as u32, record, changes: 0, removals: 0 };
            if self.strip.is_live() {
                let removed = removals.next_removals(&mut self.strip, &self.changed)?;
                event.changes = self.changed.len() as u32;
                event.removals = removed.len() as u32;
                history.changes.extend(self.changed.iter().map(|&e| self.strip.offset(e)));
                if history.changes.len() > max_changes {
                    let what = "would need far more changes than it has indices".to_owned();
                    return Err(BuildError::Malformed { array: STRIPS, what });
                }
                record_removals(&mut self.strip, removed, removal_lod, first_index, history);
            }
            history.events.push(event);
        }
        history.removal_lods.push(removal_lod);
        Ok(())
    }

    fn start(&mut self, strip: &[u32], positions: &PositionIds) {
        self.strip.start(strip, positions);
        self.queue.clear();
        self.queue.extend((0..).zip(strip).map(|(i, &v)| Reverse((v, WorkingStrip::element(i)))));
    }

    /// The record with which a strip dies: the last one that matters to it.
    fn last_record(&mut self, input: &TraceInput<'_>, strip: &[u32]) -> u32 {
        self.start(strip, input.positions);
        let (mut last, mut changes) = (0, 0);
        // Beyond this the strip is refused anyway.
        while self.strip.is_live() && changes <= max_changes(strip) {
            let Collapse { record, happens } = self.collapse_next(input);
            (last, changes) = (record, changes + self.changed.len());
            if !happens {
                break;
            }
        }
        last
    }

    /// Collapses the next vertex of the strip to disappear; `changed` has its elements then. A live
    /// strip has one.
    fn collapse_next(&mut self, input: &TraceInput<'_>) -> Collapse {
        let record = self.take_next();
        let Some(&target) = input.targets.get(record as usize) else {
            return Collapse { record, happens: false };
        };
        for &element in &self.changed {
            self.strip.set_value(element, target);
        }
        for &element in &self.changed {
            self.strip.update_drawn(element, input.positions);
            self.queue.push(Reverse((target, element)));
        }
        Collapse { record, happens: true }
    }

    /// Moves the elements of the next vertex to disappear from the queue to `changed`; returns the
    /// vertex.
    fn take_next(&mut self) -> u32 {
        self.changed.clear();
        let mut vertex = NONE;
        while let Some(&Reverse((v, element))) = self.queue.peek() {
            if self.strip.remains(element) {
                if !self.changed.is_empty() && v != vertex {
                    break;
                }
                vertex = v;
                self.changed.push(element);
            }
            self.queue.pop();
        }
        vertex
    }
}

/// Returns the number of changes a strip may have.
fn max_changes(strip: &[u32]) -> usize {
    MAX_CHANGES_PER_INDEX * (strip.len() + 100)
}

/// Adds the removals of a record to the history of the strip whose first index is `first_index`.
fn record_removals(
    strip: &mut WorkingStrip,
    removed: &[RemovedRun],
    lod: u32,
    first_index: usize,
    history: &mut History,
) {
    let first_removal = history.removals.len();
    for r in removed {
        history.removals.push(Removal {
            offset: strip.offset(r.first),
            count: r.count,
            kind: r.kind,
        });
    }
    for (r, removal) in removed.iter().zip(&history.removals[first_removal..]) {
        let mut element = r.first;
        for k in 0..r.count {
            strip.remove_rank(element);
            let index = first_index + WorkingStrip::number(element);
            history.index_removal_lods[index] = lod;
            history.is_removed_at_front[index] = r.kind == RemovalKind::Front;
            history.end_offsets[index] =
                if r.kind.period() == 0 { removal.offset + k } else { NONE };
            element = strip.next(element);
        }
        if r.kind == RemovalKind::Front {
            strip.shift_front(r.count);
        }
    }
}
