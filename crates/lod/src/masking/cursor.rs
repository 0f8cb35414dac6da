//! A cursor over Masking Strips: the strips at full length, and the filtered copies that are drawn.
//!
//! A near move streams the updates of the records passed ([`super::updates`]). A far jump looks at
//! every strip that has changed, resolves the vertices that its filter keeps, and leaves the full
//! strip for later.

use super::Masking;
use super::updates::{ROOM, Refiltered, whole};
use lodc_mesh::{Lod, OrientedTriangle};
use lodc_model::{Changes, Difference, Traffic};
use lodc_strip::live_triangles;
use std::hint::black_box;
use std::ops::Range;

const LONGEST: usize = Masking::LONGEST_STRIP;
/// Words in a cache line of most machines.
const LINE: usize = 16;
/// Number of copies whose cache lines are read together, about as many misses as a core has under
/// way at a time. Moves on meshes beyond the cache take a third less with it.
const BLOCK: usize = 16;

/// The moving part of [`Masking`] strips.
#[derive(Clone, Debug)]
pub struct Cursor {
    lod: u32,
    /// For each strip a slot of [`ROOM`] words: the full strip, then its filtered copy (what the
    /// strip's mask of positions keeps). The first starts at a cache line, behind `lead` words.
    buffer: Vec<u32>,
    lead: usize,
    /// Number of indices each filtered copy has; 0 if no triangle is left.
    counts: Vec<u8>,
    /// The strips whose full strip is that of another LOD, since a jump made the filtered copy
    /// without it; how many.
    stale: Vec<bool>,
    stale_count: usize,
    /// The vertex that each removed one has become at the LOD of the cursor; filled for far jumps
    /// only.
    shown: Vec<u32>,
    /// Kept to save allocating.
    difference: Difference,
}

impl Cursor {
    pub(super) fn new(model: &Masking) -> Self {
        let strips = model.strips.len();
        let mut buffer = vec![0; ROOM * strips + LINE];
        let lead = buffer.as_ptr().align_offset(size_of::<u32>() * LINE).min(LINE);
        for (room, strip) in buffer[lead..].chunks_exact_mut(ROOM).zip(model.strips.iter()) {
            room[..strip.len()].copy_from_slice(strip);
            room[LONGEST..][..strip.len()].copy_from_slice(strip);
        }
        let counts = model.strips.iter().map(|strip| strip.len() as u8).collect();
        Self {
            lod: 0,
            buffer,
            lead,
            counts,
            stale: vec![false; strips],
            stale_count: 0,
            shown: Vec::new(),
            difference: Difference::default(),
        }
    }

    pub(super) fn lod(&self) -> Lod {
        Lod(self.lod)
    }

    pub(super) fn drawn(&self) -> u64 {
        self.counts.iter().map(|&count| u64::from(count)).sum()
    }

    /// Returns the indices that are drawn of a strip, as a graphics card gets it: empty if none of
    /// its triangles is left.
    ///
    /// # Panics
    /// If there is no such strip.
    #[must_use]
    pub fn strip(&self, strip: usize) -> &[u32] {
        &self.buffer[self.lead + ROOM * strip + LONGEST..][..self.counts[strip] as usize]
    }

    pub(super) fn drawn_by<'a>(
        &'a self,
        model: &'a Masking,
        strip: usize,
    ) -> impl Iterator<Item = OrientedTriangle> + 'a {
        live_triangles(self.strip(strip), model.submeshes[strip], &model.positions)
    }

    pub(super) fn seek<C: Changes>(
        &mut self,
        model: &Masking,
        lod: Lod,
        changes: &mut C,
    ) -> Traffic {
        let (from, to) = (self.lod, model.simplified.collapses().floor(lod).0);
        let records = from.min(to)..from.max(to);
        let traffic = |rewritten| Traffic { records: records.end - records.start, rewritten };
        if !C::HEARD {
            return traffic(self.move_to(model, to, &records));
        }
        let mut strips = model.updates.of(&records).strips.to_vec();
        strips.sort_unstable();
        strips.dedup();
        let mut difference = std::mem::take(&mut self.difference);
        difference.clear();
        for &strip in &strips {
            difference.before(self.drawn_by(model, strip as usize));
        }
        let rewritten = self.move_to(model, to, &records);
        for (number, &strip) in strips.iter().enumerate() {
            difference.after(number, self.drawn_by(model, strip as usize), changes);
        }
        self.difference = difference;
        traffic(rewritten)
    }

    /// Returns how many indices were written, without those of full strips.
    fn move_to(&mut self, model: &Masking, to: u32, records: &Range<u32>) -> u64 {
        let run = model.updates.of(records);
        // Far: with more updates than strips it costs less to make each strip once.
        if run.strips.len() > self.counts.len() {
            model.simplified.collapses().resolve_gone(Lod(to), &mut self.shown);
            self.lod = to;
            return (0..self.counts.len()).map(|strip| self.jump(model, strip, to, records)).sum();
        }
        if self.stale_count > 0 {
            run.strips.iter().for_each(|&strip| self.refresh(model, strip as usize));
        }
        self.lod = to;
        let coarsens = to == records.end;
        let buffer = &mut self.buffer[self.lead..];
        if coarsens {
            for (&place, &target) in run.places.iter().zip(run.targets) {
                buffer[place as usize] = target;
            }
        } else {
            // Of several vertices for one place the first stays.
            for (&place, &vertex) in run.places.iter().zip(run.vertices).rev() {
                buffer[place as usize] = vertex;
            }
        }
        let mut rewritten = run.places.len() as u64;
        for block in run.copies.chunks(BLOCK) {
            if block.len() == BLOCK {
                self.touch(block);
            }
            for copy in block {
                // The last change of a strip's filter on the way alone copies it.
                let (last, filter) = if coarsens {
                    (copy.next >= to, copy.filter)
                } else {
                    (copy.since <= to, copy.before)
                };
                if last {
                    rewritten += self.copy(copy.strip as usize, filter);
                }
            }
        }
        rewritten
    }

    /// Reads a word of each cache line that some copies are going to need: all at once is faster
    /// than one after the other.
    fn touch(&self, copies: &[Refiltered]) {
        let lines = |copy: &Refiltered| {
            let at = self.lead + ROOM * copy.strip as usize;
            self.buffer[at] ^ self.buffer[at + LONGEST]
        };
        black_box(copies.iter().fold(0, |all, copy| all ^ lines(copy)));
    }

    /// Copies what a filter keeps of a full strip. Returns how many indices that are.
    fn copy(&mut self, strip: usize, filter: u16) -> u64 {
        let room = &mut self.buffer[self.lead + ROOM * strip..][..ROOM];
        let (full, drawn) = room.split_at_mut(LONGEST);
        let (filter, mut count) = (usize::from(filter), 0);
        for (at, &vertex) in full.iter().enumerate() {
            // Without a branch: what is not kept is overwritten by what follows, or lies behind the
            // end.
            drawn[count % LONGEST] = vertex;
            count += filter >> at & 1;
        }
        self.counts[strip] = count as u8;
        count as u64
    }

    /// Brings a stale full strip to the LOD of the cursor.
    fn refresh(&mut self, model: &Masking, strip: usize) {
        if !std::mem::take(&mut self.stale[strip]) {
            return;
        }
        self.stale_count -= 1;
        let (targets, input) = (model.simplified.collapses().targets(), model.strips.strip(strip));
        let full = &mut self.buffer[self.lead + ROOM * strip..][..input.len()];
        full.copy_from_slice(input);
        for entry in
            model.entries[model.history(strip)].iter().take_while(|entry| entry.record < self.lod)
        {
            each(entry.positions, |at| full[at] = targets[entry.record as usize]);
        }
    }

    /// Makes the filtered copy of a strip at a LOD with the help of `shown`, if any of some records
    /// has changed it. Returns how many indices were written.
    fn jump(&mut self, model: &Masking, strip: usize, to: u32, records: &Range<u32>) -> u64 {
        if model.removal_lods[strip] <= to {
            // A strip that is dead at the finer LOD, too, has been emptied already.
            if to == records.end && self.counts[strip] > 0 {
                self.leave(strip, 0);
            }
            return 0;
        }
        let (entries, input) = (&model.entries[model.history(strip)], model.strips.strip(strip));
        let next = entries.partition_point(|entry| entry.record < to);
        let before = next.checked_sub(1).map(|at| entries[at]);
        let passed = if to == records.end { before } else { entries.get(next).copied() };
        if !passed.is_some_and(|entry| records.contains(&entry.record)) {
            return 0;
        }
        let filter = before.map_or(whole(input.len()), |entry| entry.filter);
        let mut drawn = self.buffer[self.lead + ROOM * strip + LONGEST..].iter_mut();
        each(filter, |at| {
            if let Some(drawn) = drawn.next() {
                *drawn = self.shown.get(input[at] as usize).copied().unwrap_or(input[at]);
            }
        });
        self.leave(strip, filter.count_ones() as u8);
        u64::from(filter.count_ones())
    }

    /// Notes that a strip's filtered copy is new, its full strip stale.
    fn leave(&mut self, strip: usize, count: u8) {
        self.counts[strip] = count;
        self.stale_count += usize::from(!std::mem::replace(&mut self.stale[strip], true));
    }
}

/// Calls `f` with every position in a mask, the first first.
fn each(mut mask: u16, mut f: impl FnMut(usize)) {
    while mask != 0 {
        f(mask.trailing_zeros() as usize);
        mask &= mask - 1;
    }
}
