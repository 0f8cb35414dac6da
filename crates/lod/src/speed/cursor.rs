//! A cursor over Speed Strips: the strips of one LOD, each at the start of the room that it has at
//! LOD 0.
//!
//! A move takes one of two ways. *Near*: the changes of the records passed are streamed, in order.
//! *Far*: no change is looked at; an element that is not removed at a LOD holds what its vertex of
//! LOD 0 has become, so all strips are made anew of the stored ones. A near move that turns out to
//! write more than a far one would becomes a far one.
//!
//! The thesis gathers the changes of a strip over all records of an update and makes them in one
//! pass. With the few records of a 0.1 % step hardly any strip is met twice, and looking strips up
//! costs more than their changes: an earlier cursor that did so took 3.1 µs for a step on bunny and
//! 0.27 on cow, the first one that streamed 1.0 and 0.09.

use super::Speed;
use super::apply::{Span, remove, restore};
use super::edits::Edits;
use crate::trace::Kind;
use lodc_mesh::{Lod, NONE, OrientedTriangle};
use lodc_model::Difference;
use lodc_model::{Changes, Model, Traffic};
use lodc_strip::live_triangles;
use std::ops::Range;

/// Elements of LOD 0 that can be made anew in the time that one record's changes of one strip take
/// (measured on bunny and cow: 10 ns beside 1.5 to 5 ns).
const STRIP_COST: u64 = 4;

/// The state of a strip.
#[derive(Clone, Copy, Debug)]
struct Head {
    /// Its place, or that when it died.
    span: Span,
    /// True if it draws anything.
    live: bool,
    /// True if it was made anew, so that what had gone at its ends, or when it died, was
    /// never written.
    stale: bool,
}

/// The moving part of [`Speed`] Strips.
#[derive(Clone, Debug)]
pub struct Cursor {
    lod: u32,
    indices: Vec<u32>,
    heads: Vec<Head>,
    /// For far moves, what each vertex has become.
    shown: Vec<u32>,
    /// Kept to save allocating.
    difference: Difference,
}

impl Cursor {
    pub(super) fn new(model: &Speed) -> Self {
        let strips = model.strips();
        let head = |s: usize| {
            let room = strips.range(s);
            let span =
                Span { room: room.start as u32, start: room.start as u32, end: room.end as u32 };
            Head { span, live: model.edits().removal_lods[s] > 0, stale: false }
        };
        Self {
            lod: 0,
            indices: strips.indices().to_vec(),
            heads: (0..strips.len()).map(head).collect(),
            shown: Vec::new(),
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
        let Head { span, live, .. } = self.heads[strip];
        if live { &self.indices[span.start as usize..span.end as usize] } else { &[] }
    }

    /// Returns the number of indices that are drawn.
    pub(super) fn drawn(&self) -> u64 {
        self.heads.iter().filter(|h| h.live).map(|h| u64::from(h.span.end - h.span.start)).sum()
    }

    pub(super) fn drawn_by<'a>(
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
        if !C::HEARD {
            self.move_to(model, to, &records, &mut traffic);
            return traffic;
        }
        let mut strips: Vec<u32> = model.edits().affected(&records).collect();
        strips.sort_unstable();
        strips.dedup();
        let mut difference = std::mem::take(&mut self.difference);
        difference.clear();
        for &strip in &strips {
            difference.before(self.drawn_by(model, strip as usize));
        }
        self.move_to(model, to, &records, &mut traffic);
        for (number, &strip) in strips.iter().enumerate() {
            difference.after(number, self.drawn_by(model, strip as usize), changes);
        }
        self.difference = difference;
        traffic
    }

    fn move_to(&mut self, model: &Speed, to: u32, records: &Range<u32>, traffic: &mut Traffic) {
        let (edits, all) = (model.edits(), self.indices.len() as u64);
        let most = STRIP_COST * all;
        let near = if u64::from(edits.visits(records)) * STRIP_COST > all {
            None
        } else if to == records.end {
            self.coarsen(edits, records, most)
        } else {
            self.refine(model, records, most)
        };
        traffic.rewritten = near.unwrap_or_else(|| self.far(model, to));
        self.lod = to;
    }

    /// Applies records. Returns how many elements were written; none if that would be more than
    /// `most`, and then the strips are at none of the LODs.
    fn coarsen(&mut self, edits: &Edits, records: &Range<u32>, most: u64) -> Option<u64> {
        let run = edits.of(records);
        let (mut done, mut written) = (0, run.places.len() as u64);
        for gone in run.removals {
            let next = (gone.changes - run.first_change) as usize;
            self.write(&run.places[done..next], &run.targets[done..next]);
            done = next;
            written +=
                remove(&mut self.indices, &mut self.heads[gone.strip as usize].span, gone.removal);
            if written > most {
                return None;
            }
        }
        self.write(&run.places[done..], &run.targets[done..]);
        run.dying.iter().for_each(|&strip| self.heads[strip as usize].live = false);
        Some(written)
    }

    /// Undoes records, as [`Self::coarsen`] applies them.
    fn refine(&mut self, model: &Speed, records: &Range<u32>, most: u64) -> Option<u64> {
        let run = model.edits().of(records);
        let (mut left, mut written) = (run.places.len(), run.places.len() as u64);
        for &strip in run.dying {
            self.heads[strip as usize].live = true;
            if self.heads[strip as usize].stale {
                let lod = model.edits().removal_lods[strip as usize] - 1;
                written += self.make(model, strip as usize, lod, |v| {
                    model.simplified().collapses().resolve(v, Lod(lod))
                });
                written += self.mend_ends(model, strip as usize, lod);
            }
        }
        for gone in run.removals.iter().rev() {
            let next = (gone.changes - run.first_change) as usize;
            self.write_back(&run.places[next..left], &run.vertices[next..left]);
            left = next;
            let at_end = matches!(gone.removal.kind, Kind::Front | Kind::Back);
            if at_end && self.heads[gone.strip as usize].stale {
                written += self.mend_ends(model, gone.strip as usize, gone.record + 1);
            }
            written +=
                restore(&mut self.indices, &mut self.heads[gone.strip as usize].span, gone.removal);
            if written > most {
                return None;
            }
        }
        self.write_back(&run.places[..left], &run.vertices[..left]);
        Some(written)
    }

    fn write(&mut self, places: &[u32], values: &[u32]) {
        for (&place, &value) in places.iter().zip(values) {
            self.indices[place as usize] = value;
        }
    }

    /// Of several values for one place the first stays.
    fn write_back(&mut self, places: &[u32], values: &[u32]) {
        for (&place, &value) in places.iter().zip(values).rev() {
            self.indices[place as usize] = value;
        }
    }

    /// Writes what has gone at the ends of a stale strip until a LOD, each element as it was left.
    /// Returns how many they are.
    fn mend_ends(&mut self, model: &Speed, strip: usize, lod: u32) -> u64 {
        let (edits, room) = (model.edits(), model.strips().range(strip));
        let mut written = 0;
        for index in room.clone() {
            let (at, index_removal_lods) = (edits.left_at[index], edits.index_removal_lods[index]);
            if at != NONE && index_removal_lods <= lod {
                let vertex = model.strips().indices()[index];
                self.indices[room.start + at as usize] =
                    model.simplified().collapses().resolve(vertex, Lod(index_removal_lods - 1));
                written += 1;
            }
        }
        self.heads[strip].stale = false;
        written
    }

    /// Makes all strips anew. Returns how many elements they have.
    fn far(&mut self, model: &Speed, to: u32) -> u64 {
        let mut shown = std::mem::take(&mut self.shown);
        model.simplified().collapses().resolve_gone(Lod(to), &mut shown);
        let resolved = |v: u32| shown.get(v as usize).copied().unwrap_or(v);
        let written =
            (0..self.heads.len()).map(|strip| self.make(model, strip, to, resolved)).sum();
        self.shown = shown;
        written
    }

    /// Makes a strip anew. Returns how many elements it has.
    fn make(&mut self, model: &Speed, strip: usize, lod: u32, shown: impl Fn(u32) -> u32) -> u64 {
        let (edits, head) = (model.edits(), &mut self.heads[strip]);
        (head.live, head.stale) = (edits.removal_lods[strip] > lod, true);
        if !head.live {
            return 0;
        }
        let room = model.strips().range(strip);
        let start = room.start + edits.gone_at_front(room.clone(), lod);
        let mut end = start;
        for (&vertex, &index_removal_lods) in
            model.strips().indices()[room.clone()].iter().zip(&edits.index_removal_lods[room])
        {
            if index_removal_lods > lod {
                self.indices[end] = shown(vertex);
                end += 1;
            }
        }
        (head.span.start, head.span.end) = (start as u32, end as u32);
        (end - start) as u64
    }
}
