//! A cursor over Masking Strips: the strips at full length, and the filtered copies that are drawn.
//!
//! A near move applies the updates of the records passed, in order ([`super::updates`]). A far jump
//! looks at every strip that has changed, resolves the vertices that its filter keeps, and updates
//! the full strip when it is needed.

use super::Masking;
use super::updates::{FilterChange, SLOT_WORDS, whole_strip};
use lodc_mesh::{Lod, OrientedTriangle};
use lodc_model::{Changes, Difference, Traffic};
use lodc_strip::live_triangles;
use std::hint::black_box;
use std::ops::Range;

const LONGEST: usize = Masking::LONGEST_STRIP;
/// Words in a cache line of most machines.
const CACHE_LINE_WORDS: usize = 16;
/// Number of copies whose cache lines are prefetched together: about the number of cache misses
/// that a core has under way at a time. With it, moves on meshes larger than the cache take a third
/// less.
const PREFETCHED_COPIES: usize = 16;

/// The moving part of [`Masking`]: the strips as they are at its LOD.
#[derive(Clone, Debug)]
pub struct Cursor {
    lod: u32,
    /// For each strip a slot of [`SLOT_WORDS`] words: the full strip, then its filtered copy (what
    /// the strip's mask of positions keeps). The first starts at a cache line, behind `padding`
    /// words.
    buffer: Vec<u32>,
    padding: usize,
    /// Number of indices that each filtered copy has; 0 if no triangle is left.
    counts: Vec<u8>,
    /// For each strip whether its full strip is that of another LOD, since a jump made the filtered
    /// copy without it; and how many are.
    is_full_stale: Vec<bool>,
    stale_count: usize,
    /// For far jumps: the vertex that each removed one has become. Kept to save allocating.
    vertices_at_lod: Vec<u32>,
    /// For reports of changes. Kept to save allocating.
    difference: Difference,
}

impl Cursor {
    pub(super) fn new(model: &Masking) -> Self {
        let strips = model.strips.len();
        let mut buffer = vec![0; SLOT_WORDS * strips + CACHE_LINE_WORDS];
        let padding =
            buffer.as_ptr().align_offset(size_of::<u32>() * CACHE_LINE_WORDS).min(CACHE_LINE_WORDS);
        for (slot, strip) in buffer[padding..].chunks_exact_mut(SLOT_WORDS).zip(model.strips.iter())
        {
            slot[..strip.len()].copy_from_slice(strip);
            slot[LONGEST..][..strip.len()].copy_from_slice(strip);
        }
        let counts = model.strips.iter().map(|strip| strip.len() as u8).collect();
        Self {
            lod: 0,
            buffer,
            padding,
            counts,
            is_full_stale: vec![false; strips],
            stale_count: 0,
            vertices_at_lod: Vec::new(),
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
        &self.buffer[self.padding + SLOT_WORDS * strip + LONGEST..][..self.counts[strip] as usize]
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
        if !C::REPORTED {
            return traffic(self.move_to(model, to, &records));
        }
        let mut strips = model.updates.in_records(&records).strips.to_vec();
        strips.sort_unstable();
        strips.dedup();
        let mut difference = std::mem::take(&mut self.difference);
        difference.clear();
        for &strip in &strips {
            difference.add_before(self.drawn_by(model, strip as usize));
        }
        let rewritten = self.move_to(model, to, &records);
        for (number, &strip) in strips.iter().enumerate() {
            difference.report_after(number, self.drawn_by(model, strip as usize), changes);
        }
        self.difference = difference;
        traffic(rewritten)
    }

    /// Moves to the end of a step, past `records`. Returns how many indices were written; those of
    /// stale full strips that are made anew are not counted.
    fn move_to(&mut self, model: &Masking, to: u32, records: &Range<u32>) -> u64 {
        let run = model.updates.in_records(records);
        // Far: with more updates than strips it costs less to make each strip once.
        if run.strips.len() > self.counts.len() {
            model.simplified.collapses().resolve_gone(Lod(to), &mut self.vertices_at_lod);
            self.lod = to;
            return (0..self.counts.len())
                .map(|strip| self.remake_copy(model, strip, to, records))
                .sum();
        }
        if self.stale_count > 0 {
            run.strips.iter().for_each(|&strip| self.refresh(model, strip as usize));
        }
        self.lod = to;
        let coarsens = to == records.end;
        // Offsets are of indices of full strips, and of their copies where they have no filter
        // change.
        let buffer = &mut self.buffer[self.padding..];
        if coarsens {
            for (&offset, &target) in run.offsets.iter().zip(run.targets) {
                buffer[offset as usize] = target;
            }
        } else {
            // In reverse: of several vertices for one offset the first is written last.
            for (&offset, &vertex) in run.offsets.iter().zip(run.vertices).rev() {
                buffer[offset as usize] = vertex;
            }
        }
        let mut rewritten = run.offsets.len() as u64;
        for block in run.filter_changes.chunks(PREFETCHED_COPIES) {
            if block.len() == PREFETCHED_COPIES {
                self.prefetch(block);
            }
            for change in block {
                // Only the last of a strip's changes on the way makes its copy.
                let (is_last, filter) = if coarsens {
                    (change.next >= to, change.filter)
                } else {
                    (change.since <= to, change.previous_filter)
                };
                if is_last {
                    rewritten += self.copy_filtered(change.strip as usize, filter);
                }
            }
        }
        rewritten
    }

    /// Reads a word of each cache line that some copies are going to need: all at once is faster
    /// than one after the other.
    fn prefetch(&self, changes: &[FilterChange]) {
        let lines = |change: &FilterChange| {
            let index = self.padding + SLOT_WORDS * change.strip as usize;
            self.buffer[index] ^ self.buffer[index + LONGEST]
        };
        black_box(changes.iter().fold(0, |all, change| all ^ lines(change)));
    }

    /// Copies what a filter keeps of a full strip. Returns how many indices that are.
    fn copy_filtered(&mut self, strip: usize, filter: u16) -> u64 {
        let slot = &mut self.buffer[self.padding + SLOT_WORDS * strip..][..SLOT_WORDS];
        let (full, drawn) = slot.split_at_mut(LONGEST);
        let (filter, mut count) = (usize::from(filter), 0);
        for (index, &vertex) in full.iter().enumerate() {
            // Without a branch: what is not kept is overwritten by what follows, or lies behind the
            // end.
            drawn[count % LONGEST] = vertex;
            count += filter >> index & 1;
        }
        self.counts[strip] = count as u8;
        count as u64
    }

    /// Brings a stale full strip to the LOD of the cursor.
    fn refresh(&mut self, model: &Masking, strip: usize) {
        if !std::mem::take(&mut self.is_full_stale[strip]) {
            return;
        }
        self.stale_count -= 1;
        let (targets, input) = (model.simplified.collapses().targets(), model.strips.strip(strip));
        let full = &mut self.buffer[self.padding + SLOT_WORDS * strip..][..input.len()];
        full.copy_from_slice(input);
        for entry in
            model.entries[model.history(strip)].iter().take_while(|entry| entry.record < self.lod)
        {
            for_each_bit(entry.positions, |index| full[index] = targets[entry.record as usize]);
        }
    }

    /// Makes the filtered copy of a strip at a LOD from `vertices_at_lod`, if any of `records` has
    /// changed the strip. Returns how many indices were written.
    fn remake_copy(&mut self, model: &Masking, strip: usize, to: u32, records: &Range<u32>) -> u64 {
        if model.removal_lods[strip] <= to {
            // A strip that is dead at the finer LOD, too, has been emptied already.
            if to == records.end && self.counts[strip] > 0 {
                self.mark_stale(strip, 0);
            }
            return 0;
        }
        let (entries, input) = (&model.entries[model.history(strip)], model.strips.strip(strip));
        let next = entries.partition_point(|entry| entry.record < to);
        let previous = next.checked_sub(1).map(|index| entries[index]);
        // Of the entries between the two LODs, if there are any, the one next to the new LOD.
        let nearest = if to == records.end { previous } else { entries.get(next).copied() };
        if !nearest.is_some_and(|entry| records.contains(&entry.record)) {
            return 0;
        }
        let filter = previous.map_or(whole_strip(input.len()), |entry| entry.filter);
        let mut drawn = self.buffer[self.padding + SLOT_WORDS * strip + LONGEST..].iter_mut();
        for_each_bit(filter, |index| {
            if let Some(drawn) = drawn.next() {
                *drawn = self
                    .vertices_at_lod
                    .get(input[index] as usize)
                    .copied()
                    .unwrap_or(input[index]);
            }
        });
        self.mark_stale(strip, filter.count_ones() as u8);
        u64::from(filter.count_ones())
    }

    /// Marks a full strip as stale after its filtered copy, of `count` indices, was made without
    /// it.
    fn mark_stale(&mut self, strip: usize, count: u8) {
        self.counts[strip] = count;
        self.stale_count += usize::from(!std::mem::replace(&mut self.is_full_stale[strip], true));
    }
}

/// Calls `f` with every position in a mask, the first first.
fn for_each_bit(mut mask: u16, mut f: impl FnMut(usize)) {
    while mask != 0 {
        f(mask.trailing_zeros() as usize);
        mask &= mask - 1;
    }
}
