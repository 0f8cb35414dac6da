//! A cursor over Speed Strips: the strips of one LOD, each in the part of a buffer that it fills at
//! LOD 0.
//!
//! A move takes one of two ways. *Near*: the changes of the records passed are applied in order.
//! *Far*: no change is looked at; an element that is not removed at a LOD holds what its vertex of
//! LOD 0 has become, so all strips are rebuilt from the stored ones. A near move that turns out to
//! write more than four times as many elements as a far one becomes a far one: elements that it
//! only shifts count, too, and are cheaper than those that are made anew.
//!
//! The thesis gathers the changes of a strip over all records of an update and makes them in one
//! pass. With the few records of a 0.1 % step hardly any strip is met twice, and looking strips up
//! costs more than their changes: an earlier cursor that did so took 3.1 µs for a step on bunny and
//! 0.27 on cow, the first one that applied changes in order 1.0 and 0.09.

use super::Speed;
use super::apply::{Span, remove, restore};
use super::edits::Edits;
use crate::trace::RemovalKind;
use lodc_mesh::{Lod, NONE, OrientedTriangle};
use lodc_model::Difference;
use lodc_model::{Changes, Model, Traffic};
use lodc_strip::live_triangles;
use std::ops::Range;

/// Elements of LOD 0 that a far move makes anew in the time in which a near one makes one record's
/// changes of one strip (measured on bunny and cow: 10 ns for those, 1.5 to 5 ns for an element).
const ELEMENTS_PER_VISIT: u64 = 4;

/// The state of a strip.
#[derive(Clone, Copy, Debug)]
struct StripState {
    /// Its span; of a dead one that when it died.
    span: Span,
    live: bool,
    /// True if a far move rebuilt it: that does not write the elements that were removed at its
    /// ends, or those of a dead strip.
    lacks_removed: bool,
}

/// The moving part of [`Speed`] Strips.
#[derive(Clone, Debug)]
pub struct Cursor {
    lod: u32,
    indices: Vec<u32>,
    /// The state of each strip.
    states: Vec<StripState>,
    /// A buffer for far moves: what each vertex has become.
    vertices_at_lod: Vec<u32>,
    /// Buffer for reporting changes.
    difference: Difference,
}

impl Cursor {
    pub(super) fn new(model: &Speed) -> Self {
        let strips = model.strips();
        let state = |s: usize| {
            let room = strips.range(s);
            let span =
                Span { room: room.start as u32, start: room.start as u32, end: room.end as u32 };
            StripState { span, live: model.edits().removal_lods[s] > 0, lacks_removed: false }
        };
        Self {
            lod: 0,
            indices: strips.indices().to_vec(),
            states: (0..strips.len()).map(state).collect(),
            vertices_at_lod: Vec::new(),
            difference: Difference::default(),
        }
    }

    /// Returns the LOD where the cursor is.
    #[must_use]
    pub fn lod(&self) -> Lod {
        Lod(self.lod)
    }

    /// A strip as it is drawn: nothing, once it is dead.
    #[must_use]
    pub fn strip(&self, strip: usize) -> &[u32] {
        let StripState { span, live, .. } = self.states[strip];
        if live { &self.indices[span.start as usize..span.end as usize] } else { &[] }
    }

    /// Returns the number of indices that are drawn.
    pub(super) fn drawn(&self) -> u64 {
        self.states.iter().filter(|s| s.live).map(|s| u64::from(s.span.end - s.span.start)).sum()
    }

    /// The live triangles of a strip.
    pub(super) fn strip_triangles<'a>(
        &'a self,
        model: &'a Speed,
        strip: usize,
    ) -> impl Iterator<Item = OrientedTriangle> + 'a {
        live_triangles(self.strip(strip), model.submesh_of(strip), model.positions())
    }

    pub(super) fn seek<C: Changes>(&mut self, model: &Speed, lod: Lod, changes: &mut C) -> Traffic {
        let (from, to) = (self.lod, model.simplified().collapses().floor(lod).0);
        if from == to {
            return Traffic::default();
        }
        let records = from.min(to)..from.max(to);
        let mut traffic = Traffic { records: records.end - records.start, ..Traffic::default() };
        if !C::REPORTED {
            self.move_to(model, to, &records, &mut traffic);
            return traffic;
        }
        let mut strips: Vec<u32> = model.edits().affected(&records).collect();
        strips.sort_unstable();
        strips.dedup();
        let mut difference = std::mem::take(&mut self.difference);
        difference.clear();
        for &strip in &strips {
            difference.add_before(self.strip_triangles(model, strip as usize));
        }
        self.move_to(model, to, &records, &mut traffic);
        for (number, &strip) in strips.iter().enumerate() {
            difference.report_after(number, self.strip_triangles(model, strip as usize), changes);
        }
        self.difference = difference;
        traffic
    }

    fn move_to(&mut self, model: &Speed, to: u32, records: &Range<u32>, traffic: &mut Traffic) {
        let (edits, all) = (model.edits(), self.indices.len() as u64);
        let max_written = ELEMENTS_PER_VISIT * all;
        let near = if u64::from(edits.visits(records)) * ELEMENTS_PER_VISIT > all {
            None
        } else if to == records.end {
            self.coarsen(edits, records, max_written)
        } else {
            self.refine(model, records, max_written)
        };
        traffic.rewritten = near.unwrap_or_else(|| self.rebuild(model, to));
        self.lod = to;
    }

    /// Applies records. Returns how many elements were written; none if that would be more than
    /// `max_written`, and then the strips are at none of the LODs.
    fn coarsen(&mut self, edits: &Edits, records: &Range<u32>, max_written: u64) -> Option<u64> {
        let run = edits.of(records);
        let (mut done, mut written) = (0, run.offsets.len() as u64);
        for removed in run.removals {
            let next = (removed.changes_before - run.first_change) as usize;
            self.write_targets(&run.offsets[done..next], &run.targets[done..next]);
            done = next;
            written += remove(
                &mut self.indices,
                &mut self.states[removed.strip as usize].span,
                removed.removal,
            );
            if written > max_written {
                return None;
            }
        }
        self.write_targets(&run.offsets[done..], &run.targets[done..]);
        run.dying.iter().for_each(|&strip| self.states[strip as usize].live = false);
        Some(written)
    }

    /// Undoes records, as [`Self::coarsen`] applies them.
    fn refine(&mut self, model: &Speed, records: &Range<u32>, max_written: u64) -> Option<u64> {
        let run = model.edits().of(records);
        let (mut end, mut written) = (run.offsets.len(), run.offsets.len() as u64);
        // Its death is a strip's last change, so it is undone first.
        for &strip in run.dying {
            self.states[strip as usize].live = true;
            if self.states[strip as usize].lacks_removed {
                let lod = model.edits().removal_lods[strip as usize] - 1;
                written += self.rebuild_strip(model, strip as usize, lod, |v| {
                    model.simplified().collapses().resolve(v, Lod(lod))
                });
                written += self.restore_ends(model, strip as usize, lod);
            }
        }
        for removed in run.removals.iter().rev() {
            let next = (removed.changes_before - run.first_change) as usize;
            self.write_vertices(&run.offsets[next..end], &run.vertices[next..end]);
            end = next;
            let at_end = matches!(removed.removal.kind, RemovalKind::Front | RemovalKind::Back);
            if at_end && self.states[removed.strip as usize].lacks_removed {
                written += self.restore_ends(model, removed.strip as usize, removed.record + 1);
            }
            written += restore(
                &mut self.indices,
                &mut self.states[removed.strip as usize].span,
                removed.removal,
            );
            if written > max_written {
                return None;
            }
        }
        self.write_vertices(&run.offsets[..end], &run.vertices[..end]);
        Some(written)
    }

    fn write_targets(&mut self, offsets: &[u32], values: &[u32]) {
        for (&offset, &value) in offsets.iter().zip(values) {
            self.indices[offset as usize] = value;
        }
    }

    /// Of several values for one offset the first stays.
    fn write_vertices(&mut self, offsets: &[u32], values: &[u32]) {
        for (&offset, &value) in offsets.iter().zip(values).rev() {
            self.indices[offset as usize] = value;
        }
    }

    /// Writes the elements that were removed at the ends of a strip that lacks them, up to a LOD,
    /// each as it was when it was removed. Returns how many they are.
    fn restore_ends(&mut self, model: &Speed, strip: usize, lod: u32) -> u64 {
        let (edits, room) = (model.edits(), model.strips().range(strip));
        let mut written = 0;
        for index in room.clone() {
            let (at, removal_lod) = (edits.end_offsets[index], edits.index_removal_lods[index]);
            if at != NONE && removal_lod <= lod {
                let vertex = model.strips().indices()[index];
                self.indices[room.start + at as usize] =
                    model.simplified().collapses().resolve(vertex, Lod(removal_lod - 1));
                written += 1;
            }
        }
        self.states[strip].lacks_removed = false;
        written
    }

    /// Rebuilds all strips: the far move. Returns how many elements they have.
    fn rebuild(&mut self, model: &Speed, to: u32) -> u64 {
        let mut vertices_at_lod = std::mem::take(&mut self.vertices_at_lod);
        model.simplified().collapses().resolve_gone(Lod(to), &mut vertices_at_lod);
        let resolved = |v: u32| vertices_at_lod.get(v as usize).copied().unwrap_or(v);
        let written = (0..self.states.len())
            .map(|strip| self.rebuild_strip(model, strip, to, resolved))
            .sum();
        self.vertices_at_lod = vertices_at_lod;
        written
    }

    /// Rebuilds a strip. Returns how many elements it has.
    fn rebuild_strip(
        &mut self,
        model: &Speed,
        strip: usize,
        lod: u32,
        vertex_at_lod: impl Fn(u32) -> u32,
    ) -> u64 {
        let (edits, state) = (model.edits(), &mut self.states[strip]);
        (state.live, state.lacks_removed) = (edits.removal_lods[strip] > lod, true);
        if !state.live {
            return 0;
        }
        let room = model.strips().range(strip);
        let start = room.start + edits.removed_at_front(room.clone(), lod);
        let mut end = start;
        for (&vertex, &removal_lod) in
            model.strips().indices()[room.clone()].iter().zip(&edits.index_removal_lods[room])
        {
            if removal_lod > lod {
                self.indices[end] = vertex_at_lod(vertex);
                end += 1;
            }
        }
        (state.span.start, state.span.end) = (start as u32, end as u32);
        (end - start) as u64
    }
}
