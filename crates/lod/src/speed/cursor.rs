//! A cursor over Speed Strips: the strips of one LOD, each at the start of the room that it has at LOD 0.
//!
//! A move takes one of two ways. *Near*: the changes of the records passed are streamed, in order. *Far*: no change is
//! looked at; an element that is not removed at a LOD holds what its vertex of LOD 0 has become, so all strips are
//! made anew of the stored ones. A near move that turns out to write more than a far one would becomes a far one.
//!
//! The thesis gathers the changes of a strip over all records of an update and makes them in one pass. With the few
//! records of a 0.1 % step hardly any strip is met twice, and looking strips up costs more than their changes: streaming
//! was two to three times faster (bunny, igea).

use super::Speed;
use super::apply::{remove, restore};
use super::difference::{Difference, drawn};
use crate::{Changes, Model, Traffic};
use lodc_mesh::{Lod, OrientedTriangle};
use std::ops::Range;

/// One record's changes of one strip cost about as much as making so many elements of LOD 0 anew (measured on bunny and cow:
/// 10 ns against 1.5 to 5 ns).
const STRIP_COST: u64 = 4;

/// What a strip is at the moment.
#[derive(Clone, Copy, Debug)]
struct Head {
    /// Where its room starts.
    first: u32,
    /// Elements that it has, or had when it died.
    length: u32,
    /// The move that counted it last.
    counted: u32,
    /// Whether it draws anything.
    live: bool,
    /// Whether it died in a far move, so that what it had then was never written.
    stale: bool,
}

/// The moving part of [`Speed`] Strips.
#[derive(Clone, Debug)]
pub struct Cursor {
    lod: u32,
    indices: Vec<u32>,
    heads: Vec<Head>,
    moves: u32,
    /// For far moves, what each vertex has become.
    shown: Vec<u32>,
}

impl Cursor {
    pub(super) fn new(model: &Speed) -> Self {
        let strips = model.strips();
        let head = |s: usize| Head {
            first: strips.range(s).start as u32,
            length: strips.range(s).len() as u32,
            counted: 0,
            live: model.edits().deaths[s] > 0,
            stale: false,
        };
        Self {
            lod: 0,
            indices: strips.indices().to_vec(),
            heads: (0..strips.len()).map(head).collect(),
            moves: 0,
            shown: Vec::new(),
        }
    }

    /// Where the cursor is.
    #[must_use]
    pub fn lod(&self) -> Lod {
        Lod(self.lod)
    }

    /// A strip as it is drawn: nothing, once it is dead.
    #[must_use]
    pub fn strip(&self, strip: usize) -> &[u32] {
        let head = &self.heads[strip];
        let length = if head.live { head.length } else { 0 };
        &self.indices[head.first as usize..][..length as usize]
    }

    /// How many indices are drawn.
    pub(super) fn drawn(&self) -> u64 {
        self.heads.iter().filter(|h| h.live).map(|h| u64::from(h.length)).sum()
    }

    pub(super) fn triangles(&self, model: &Speed) -> Vec<OrientedTriangle> {
        (0..self.heads.len()).flat_map(|strip| self.drawn_by(model, strip)).collect()
    }

    fn drawn_by<'a>(&'a self, model: &'a Speed, strip: usize) -> impl Iterator<Item = OrientedTriangle> + 'a {
        drawn(self.strip(strip), model.submesh_of(strip), model.positions())
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
        let mut strips = model.edits().affected(records.clone()).to_vec();
        strips.sort_unstable();
        strips.dedup();
        let before: Vec<Vec<_>> = strips.iter().map(|&s| self.drawn_by(model, s as usize).collect()).collect();
        self.move_to(model, to, &records, &mut traffic);
        let mut difference = Difference::default();
        for (before, strip) in before.into_iter().zip(strips) {
            difference.before(before.into_iter());
            difference.after(self.drawn_by(model, strip as usize), to > from, records.end, changes);
        }
        traffic
    }

    fn move_to(&mut self, model: &Speed, to: u32, records: &Range<u32>, traffic: &mut Traffic) {
        let (edits, all) = (model.edits(), self.indices.len() as u64);
        let affected = edits.affected(records.clone());
        let near = affected.len() as u64 * STRIP_COST <= all && {
            let written = if to == records.end {
                self.coarsen(model, records, STRIP_COST * all)
            } else {
                self.refine(model, records, STRIP_COST * all)
            };
            written.inspect(|&written| traffic.rewritten = written).is_some()
        };
        if near {
            traffic.bytes = 4 * self.count(affected);
        } else {
            traffic.rewritten = self.far(model, to);
            traffic.bytes = 4 * traffic.rewritten;
        }
        self.lod = to;
    }

    /// Applies records. Returns how many elements were written; none if that would be more than `most`, and then the
    /// strips are at none of the LODs.
    fn coarsen(&mut self, model: &Speed, records: &Range<u32>, most: u64) -> Option<u64> {
        let edits = model.edits();
        let targets = model.simplified().collapses().targets();
        let mut written = 0;
        for record in records.clone() {
            let target = targets[record as usize];
            let places = edits.changes(record);
            for &place in places {
                self.indices[place as usize] = target;
            }
            written += places.len() as u64;
            for removals in edits.removals(record).chunk_by(|a, b| a.0 == b.0) {
                let head = &mut self.heads[removals[0].0 as usize];
                written += remove(&mut self.indices[head.first as usize..], &mut head.length, removals);
            }
            for &strip in edits.dying(record) {
                self.heads[strip as usize].live = false;
            }
            if written > most {
                return None;
            }
        }
        Some(written)
    }

    /// Undoes records, as [`Self::coarsen`] applies them.
    fn refine(&mut self, model: &Speed, records: &Range<u32>, most: u64) -> Option<u64> {
        let edits = model.edits();
        let mut written = 0;
        for record in records.clone().rev() {
            for &strip in edits.dying(record) {
                let head = &mut self.heads[strip as usize];
                head.live = true;
                if head.stale {
                    let collapses = model.simplified().collapses();
                    written += self.make(model, strip as usize, record, |v| collapses.resolve(v, Lod(record)));
                }
            }
            for removals in edits.removals(record).chunk_by(|a, b| a.0 == b.0) {
                let head = &mut self.heads[removals[0].0 as usize];
                written += restore(&mut self.indices[head.first as usize..], &mut head.length, removals);
            }
            let places = edits.changes(record);
            for &place in places {
                self.indices[place as usize] = record;
            }
            written += places.len() as u64;
            if written > most {
                return None;
            }
        }
        Some(written)
    }

    /// Makes all strips anew. Returns how many elements they have.
    fn far(&mut self, model: &Speed, to: u32) -> u64 {
        let mut shown = std::mem::take(&mut self.shown);
        resolve_below(model.simplified().collapses().targets(), to, &mut shown);
        let resolved = |v: u32| shown.get(v as usize).copied().unwrap_or(v);
        let written = (0..self.heads.len()).map(|strip| self.make(model, strip, to, resolved)).sum();
        self.shown = shown;
        written
    }

    /// Makes a strip anew. Returns how many elements it has.
    fn make(&mut self, model: &Speed, strip: usize, lod: u32, shown: impl Fn(u32) -> u32) -> u64 {
        let (edits, head) = (model.edits(), &mut self.heads[strip]);
        head.live = edits.deaths[strip] > lod;
        head.stale = !head.live;
        if !head.live {
            return 0;
        }
        let room = model.strips().range(strip);
        let elements = &mut self.indices[room.clone()];
        let mut length = 0;
        for (&vertex, &removed_at) in model.strips().indices()[room.clone()].iter().zip(&edits.removed_at[room]) {
            if removed_at > lod {
                elements[length] = shown(vertex);
                length += 1;
            }
        }
        head.length = length as u32;
        length as u64
    }

    /// The elements of some strips, each of which counts once.
    fn count(&mut self, strips: &[u32]) -> u64 {
        if self.moves == u32::MAX {
            self.heads.iter_mut().for_each(|h| h.counted = 0);
            self.moves = 0;
        }
        self.moves += 1;
        let mut elements = 0;
        for &strip in strips {
            let head = &mut self.heads[strip as usize];
            if head.live && head.counted != self.moves {
                elements += u64::from(head.length);
            }
            head.counted = self.moves;
        }
        elements
    }
}

/// What each vertex below `lod` has become at it.
fn resolve_below(targets: &[u32], lod: u32, shown: &mut Vec<u32>) {
    shown.clear();
    shown.extend_from_slice(&targets[..lod as usize]);
    for k in (0..lod as usize).rev() {
        if let Some(&further) = shown.get(shown[k] as usize) {
            shown[k] = further;
        }
    }
}
