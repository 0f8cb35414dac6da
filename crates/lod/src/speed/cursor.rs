//! A cursor over Speed Strips: the strips of one LOD, each at the start of the room that it has at LOD 0.
//!
//! A move takes one of two ways. *Near*: the entries of the records passed are looked at in order; the first one of
//! a strip takes along all others of the same strip, so every strip is visited once, however many records there are. A
//! strip in which so much changes that rewriting it is cheaper is rewritten. *Far*: no entry is looked at; an
//! element that is not removed at a LOD holds what its vertex of LOD 0 has become, so all strips are rewritten from
//! the stored ones.

use super::Speed;
use super::apply::{coarsen, refine};
use super::difference::{Difference, drawn};
use super::edits::{Edits, NONE};
use crate::{Changes, Model, Traffic};
use lodc_mesh::{Lod, OrientedTriangle};
use std::ops::Range;

/// An entry passed costs about as much as rewriting so many indices of LOD 0 (measured on scans of 70,000 to a million
/// triangles, where it is 5 to 9).
const ENTRY_COST: u64 = 6;

/// Making an element anew costs about as much as moving so many: its vertex has to be followed through its collapses.
const REWRITE_COST: u64 = 12;

/// What a strip is at the moment.
#[derive(Clone, Copy, Debug)]
struct Head {
    /// Where its elements start.
    first: u32,
    /// Elements that it has, or had when it died.
    length: u32,
    /// The move that visited it last.
    visited: u32,
    /// Whether it draws anything.
    live: bool,
    /// Whether its elements are those of its death, though it died in a far move and they were never written.
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
    difference: Difference,
}

/// One move.
#[derive(Clone, Copy, Debug)]
struct Move {
    coarsens: bool,
    to: u32,
    coarse: u32,
}

impl Cursor {
    pub(super) fn new(model: &Speed) -> Self {
        let strips = model.strips();
        let head = |s: usize| Head {
            first: strips.range(s).start as u32,
            length: strips.range(s).len() as u32,
            visited: 0,
            live: model.edits().deaths[s] > 0,
            stale: false,
        };
        Self {
            lod: 0,
            indices: strips.indices().to_vec(),
            heads: (0..strips.len()).map(head).collect(),
            moves: 0,
            shown: Vec::new(),
            difference: Difference::default(),
        }
    }

    /// Where the cursor is.
    #[must_use]
    pub fn lod(&self) -> Lod {
        Lod(self.lod)
    }

    /// A strip as it is drawn: nothing, once it is dead.
    pub(super) fn strip(&self, model: &Speed, strip: usize) -> &[u32] {
        let head = &self.heads[strip];
        let first = head.first as usize;
        if head.live { &self.indices[first..first + head.length as usize] } else { &[] }
    }

    pub(super) fn triangles(&self, model: &Speed) -> Vec<OrientedTriangle> {
        let strips = (0..).zip(model.strips().submeshes());
        strips.flat_map(|(s, submesh)| drawn(self.strip(model, s), submesh, model.positions())).collect()
    }

    pub(super) fn seek(&mut self, model: &Speed, lod: Lod, changes: &mut impl Changes) -> Traffic {
        let (from, to) = (self.lod, model.simplified().collapses().floor(lod).0);
        if from == to {
            return Traffic::default();
        }
        let (fine, coarse) = (from.min(to), from.max(to));
        let entries = model.edits().of_records(fine..coarse);
        let step = Move { coarsens: to > from, to, coarse };
        self.next_move();
        let mut traffic = Traffic { records: coarse - fine, ..Traffic::default() };
        if u64::from(entries.end - entries.start) * ENTRY_COST > model.strips().separate_indices() {
            self.far(model, step, &mut traffic, changes);
        } else if step.coarsens {
            for entry in entries.clone() {
                self.visit(model, entry, &entries, step, &mut traffic, changes);
            }
        } else {
            for entry in entries.clone().rev() {
                self.visit(model, entry, &entries, step, &mut traffic, changes);
            }
        }
        self.lod = to;
        traffic
    }

    fn next_move(&mut self) {
        if self.moves == u32::MAX {
            self.heads.iter_mut().for_each(|h| h.visited = 0);
            self.moves = 0;
        }
        self.moves += 1;
    }

    /// Takes the strip of an entry to where the move goes, unless it is there already.
    fn visit(
        &mut self,
        model: &Speed,
        entry: u32,
        entries: &Range<u32>,
        step: Move,
        traffic: &mut Traffic,
        changes: &mut impl Changes,
    ) {
        let strip = model.edits().get(entry).strip as usize;
        if self.heads[strip].visited == self.moves {
            return;
        }
        self.heads[strip].visited = self.moves;
        traffic.rewritten +=
            self.told(model, strip, step, changes, |cursor| cursor.walk(model, strip, entry, entries, step));
        if self.heads[strip].live {
            traffic.bytes += 4 * u64::from(self.heads[strip].length);
        }
    }

    /// Changes a strip and tells of the triangles, if anybody listens.
    fn told<C: Changes, T>(
        &mut self,
        model: &Speed,
        strip: usize,
        step: Move,
        changes: &mut C,
        change: impl FnOnce(&mut Self) -> T,
    ) -> T {
        if !C::HEARD {
            return change(self);
        }
        let submesh = model.submesh_of(strip);
        let mut difference = std::mem::take(&mut self.difference);
        difference.before(drawn(self.strip(model, strip), submesh, model.positions()));
        let result = change(self);
        let after = drawn(self.strip(model, strip), submesh, model.positions());
        difference.after(after, step.coarsens, step.coarse, changes);
        self.difference = difference;
        result
    }

    /// Applies or undoes the entries of one strip, from `entry` on. Returns how many elements were written.
    fn walk(&mut self, model: &Speed, strip: usize, mut entry: u32, entries: &Range<u32>, step: Move) -> u64 {
        let edits = model.edits();
        let targets = model.simplified().collapses().targets();
        let head = &mut self.heads[strip];
        let elements = &mut self.indices[head.first as usize..];
        let mut written = 0;
        loop {
            let e = edits.get(entry);
            let (places, removals) = (edits.changes(entry), edits.removals(entry));
            if places.is_empty() {
                // With this record it dies. What it was stays where it is, for the way back.
                head.live = !step.coarsens;
                if head.live && head.stale {
                    return written + self.rewrite(model, strip, step.to);
                }
            } else if step.coarsens {
                let target = targets[e.record as usize];
                written += u64::from(coarsen(elements, &mut head.length, places, removals, target));
            } else {
                written += u64::from(refine(elements, &mut head.length, places, removals, e.record));
            }
            entry = if step.coarsens { e.next } else { e.previous };
            if entry == NONE || !entries.contains(&entry) {
                return written;
            }
            if written > REWRITE_COST * model.strips().range(strip).len() as u64 {
                return written + self.rewrite(model, strip, step.to);
            }
        }
    }

    /// Makes a strip anew, of the stored one.
    fn rewrite(&mut self, model: &Speed, strip: usize, lod: u32) -> u64 {
        let edits = model.edits();
        let collapses = model.simplified().collapses();
        let head = &mut self.heads[strip];
        head.live = edits.deaths[strip] > lod;
        head.stale = !head.live;
        if !head.live {
            return 0;
        }
        let room = model.strips().range(strip);
        head.length =
            fill(edits, model.strips().indices(), &mut self.indices, room, lod, |v| collapses.resolve(v, Lod(lod)));
        u64::from(head.length)
    }

    fn far(&mut self, model: &Speed, step: Move, traffic: &mut Traffic, changes: &mut impl Changes) {
        let mut shown = std::mem::take(&mut self.shown);
        resolve_below(model.simplified().collapses().targets(), step.to, &mut shown);
        for strip in 0..self.heads.len() {
            let written = self.told(model, strip, step, changes, |cursor| {
                let (edits, head) = (model.edits(), &mut cursor.heads[strip]);
                head.live = edits.deaths[strip] > step.to;
                head.stale = !head.live;
                if !head.live {
                    return 0;
                }
                let room = model.strips().range(strip);
                head.length = fill(edits, model.strips().indices(), &mut cursor.indices, room, step.to, |v| {
                    shown.get(v as usize).copied().unwrap_or(v)
                });
                u64::from(head.length)
            });
            traffic.rewritten += written;
            traffic.bytes += 4 * written;
        }
        self.shown = shown;
    }
}

/// Writes a strip as it is at a LOD at which it is live. Returns its length.
fn fill(
    edits: &Edits,
    stored: &[u32],
    indices: &mut [u32],
    room: Range<usize>,
    lod: u32,
    shown: impl Fn(u32) -> u32,
) -> u32 {
    let elements = &mut indices[room.clone()];
    let mut length = 0;
    for (&vertex, &removed_at) in stored[room.clone()].iter().zip(&edits.removed_at[room]) {
        if removed_at > lod {
            elements[length] = shown(vertex);
            length += 1;
        }
    }
    length as u32
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
