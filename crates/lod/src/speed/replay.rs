//! Speed Strips on a graphics device as a [`Plan`], the variant *direct* of the thesis: compute
//! passes apply the edits to the strips in the device's memory.

use super::{RemovalKind, Speed};
use crate::cpu::move_and_compare;
use lodc_mesh::{Lod, NONE};
use lodc_model::Model;
use lodc_plan::{
    BufferId, KernelId, LONGEST_LOOP, PackedStrips, Pass, Plan, PlanError, Program, SCAN, SCAN_ADD,
    STRIP_DRAWS, Shader, Step,
};
use lodc_verify::Reference;

const EDITS: Shader = Shader { name: "edits", wgsl: include_str!("edits.wgsl") };
const VALUES: Shader = Shader { name: "values", wgsl: include_str!("values.wgsl") };
const REWRITE: Shader = Shader { name: "rewrite", wgsl: include_str!("rewrite.wgsl") };
const LENGTHS: Shader = Shader { name: "lengths", wgsl: include_str!("lengths.wgsl") };
const PACK: Shader = Shader { name: "pack", wgsl: include_str!("pack.wgsl") };

/// The kernels, for replay and for engines.
pub const SHADERS: [Shader; 8] =
    [EDITS, VALUES, REWRITE, LENGTHS, SCAN, SCAN_ADD, PACK, STRIP_DRAWS];

/// Indices that can be made anew in the time that applying an entry takes. An estimate from the
/// CPU; not measured on devices.
const INDICES_PER_ENTRY: u64 = 6;

/// Buffers and kernels; the first four buffers are those of [`EditsByStrip`].
#[derive(Clone, Debug)]
pub(super) struct Device {
    starts: BufferId,
    entries: BufferId,
    changes: BufferId,
    removals: BufferId,
    collapse_to: BufferId,
    stored: BufferId,
    strip_of: BufferId,
    removal_lods: BufferId,
    index_removal_lods: BufferId,
    values: BufferId,
    strips: BufferId,
    /// Two words for each strip: its first entry that is not applied, and its present number of
    /// indices.
    strip_states: BufferId,
    packed: PackedStrips,
    kernels: [KernelId; 5],
    strip_count: u32,
    index_count: u32,
}

impl Device {
    /// The strips as they are drawn.
    pub(super) fn packed(&self) -> &PackedStrips {
        &self.packed
    }

    pub(super) fn new(program: &mut Program, model: &Speed) -> Result<Self, PlanError> {
        let set = &model.strips.set;
        let longest = set.iter().map(<[u32]>::len).max().unwrap_or(0) as u32;
        if longest > LONGEST_LOOP {
            let what = "a strip";
            return Err(PlanError::TooDeep { what, rounds: longest, most: LONGEST_LOOP });
        }
        let EditsByStrip { starts, entries, changes, removals } = EditsByStrip::new(model);
        let strip_states = starts
            .chunks_exact(2)
            .zip(set.iter())
            .flat_map(|(start, strip)| [start[1], strip.len() as u32]);
        let strip_states: Vec<u32> = strip_states.collect();
        let strip_of: Vec<u32> =
            (0..set.len()).flat_map(|s| set.range(s).map(move |_| s as u32)).collect();
        Ok(Self {
            starts: program.words("starts", starts),
            entries: program.words("entries", entries),
            changes: program.words("changes", changes),
            removals: program.words("removals", removals),
            collapse_to: program.words("collapse_to", model.simplified.collapses().targets()),
            stored: program.words("stored", set.indices()),
            strip_of: program.words("strip_of", strip_of),
            removal_lods: program.words("removal_lods", model.removal_lods()),
            index_removal_lods: program.words("index_removal_lods", model.index_removal_lods()),
            values: program.zeros("values", set.indices().len()),
            strips: program.words("strips", set.indices()),
            strip_states: program.words("strip_states", strip_states),
            packed: PackedStrips::new(program, set),
            kernels: [EDITS, VALUES, REWRITE, LENGTHS, PACK].map(|shader| program.kernel(shader)),
            strip_count: set.len() as u32,
            index_count: set.indices().len() as u32,
        })
    }

    /// Takes the strips from one LOD to another: in place if that is less work, and no strip
    /// changes so often that a kernel may not loop that long; else anew.
    pub(super) fn passes(&self, model: &Speed, from: Lod, to: Lod) -> Vec<Pass> {
        let [edits, values, rewrite, lengths, pack] = self.kernels;
        let (strips, indices) = (self.strip_count, self.index_count);
        let pass =
            |kernel, threads, buffers, parameters| Pass { kernel, buffers, threads, parameters };
        let mut passes = if model.is_near(from, to) {
            let buffers = vec![
                self.starts,
                self.entries,
                self.changes,
                self.removals,
                self.collapse_to,
                self.strips,
                self.strip_states,
            ];
            vec![pass(edits, strips, buffers, vec![strips, to.0])]
        } else {
            let value_buffers =
                vec![self.stored, self.strip_of, self.removal_lods, self.collapse_to, self.values];
            let rewrite_buffers = vec![
                self.starts,
                self.entries,
                self.removal_lods,
                self.index_removal_lods,
                self.values,
                self.strips,
                self.strip_states,
            ];
            vec![
                pass(values, indices, value_buffers, vec![indices, to.0]),
                pass(rewrite, strips, rewrite_buffers, vec![strips, to.0]),
            ]
        };
        let offsets = self.packed.offsets;
        passes.push(pass(
            lengths,
            strips + 1,
            vec![self.removal_lods, self.strip_states, offsets],
            vec![strips, to.0],
        ));
        let write = pass(
            pack,
            strips,
            vec![self.starts, self.strips, offsets, self.packed.drawn],
            vec![strips],
        );
        passes.extend(self.packed.around(write));
        passes
    }
}

/// The edits strip by strip, in words as kernels read them.
struct EditsByStrip {
    /// Two for each strip, and two more: where its indices start, and its entries.
    starts: Vec<u32>,
    /// Four for each entry (a record that changes the strip), and four more: the record, where its
    /// changes start, where its removals start, and where what it puts back at ends starts in
    /// `changes`.
    entries: Vec<u32>,
    /// The offsets that change; behind all of them, the vertices that are put back at ends.
    changes: Vec<u32>,
    /// Two for each removal: its offset, and [`Removal::word`](super::Removal::word).
    removals: Vec<u32>,
}

impl EditsByStrip {
    fn new(model: &Speed) -> Self {
        let (set, records) = (&model.strips.set, model.edits().records());
        // How many entries, changes and removals each strip has; then where the next ones go.
        let mut next = vec![[0u32; 3]; set.len() + 1];
        for event in (0..records).flat_map(|record| model.events(record)) {
            let [entries, changes, removals] = &mut next[event.strip as usize + 1];
            *entries += 1;
            *changes += event.changes.len() as u32;
            *removals += event.removals.len() as u32;
        }
        for strip in 0..set.len() {
            let previous = next[strip];
            next[strip + 1].iter_mut().zip(previous).for_each(|(n, previous)| *n += previous);
        }
        let end = next[set.len()];
        let first_offsets =
            (0..set.len()).map(|strip| set.range(strip).start).chain([set.indices().len()]);
        let starts = first_offsets
            .zip(&next)
            .flat_map(|(offset, [first, ..])| [offset as u32, *first])
            .collect();
        let mut entries = vec![0; 4 * end[0] as usize];
        let (mut changes, mut removals) = (vec![0; end[1] as usize], vec![0; 2 * end[2] as usize]);
        // Kernels leave no gap at the front: offsets count from where a strip starts at the time.
        let mut fronts: Vec<u32> =
            (0..set.len()).map(|strip| set.range(strip).start as u32).collect();
        for record in 0..records {
            for event in model.events(record) {
                let strip = event.strip as usize;
                let ([entry, change, removal], first) =
                    (&mut next[strip], set.range(strip).start as u32);
                // What is put back at ends follows all offsets.
                let ends_start = changes.len() as u32;
                entries[4 * *entry as usize..][..4]
                    .copy_from_slice(&[record, *change, *removal, ends_start]);
                *entry += 1;
                for offset in event.changes {
                    changes[*change as usize] = offset - fronts[strip];
                    *change += 1;
                }
                let mut removed_at_front = 0;
                for removed in event.removals.iter().rev() {
                    let at = removed.removal.offset - (fronts[strip] - first);
                    removals[2 * *removal as usize..][..2]
                        .copy_from_slice(&[at, removed.removal.word().cast_unsigned()]);
                    *removal += 1;
                    if removed.removal.kind == RemovalKind::Front {
                        removed_at_front = removed.removal.count;
                    }
                }
                fronts[strip] += removed_at_front;
                for kind in event.removals.iter().rev().map(|removed| removed.removal.kind) {
                    if kind == RemovalKind::Front || kind == RemovalKind::Back {
                        changes.extend(removed_end(model, strip, record, kind));
                    }
                }
            }
        }
        // Where the last strip's entries end, with their changes and removals.
        entries.extend([NONE, end[1], end[2], 0]);
        Self { starts, entries, changes, removals }
    }
}

/// Returns what the elements that a record removes at the front or the back of a strip have become
/// by then, in order.
fn removed_end(
    model: &Speed,
    strip: usize,
    record: u32,
    kind: RemovalKind,
) -> impl Iterator<Item = u32> {
    let (range, lod) = (model.strips.range(strip), record + 1);
    let index_removal_lods = &model.index_removal_lods()[range.clone()];
    // Only what is removed at the back is behind the last remaining element.
    let last_remaining = index_removal_lods
        .iter()
        .rposition(|&at| at > lod)
        .map_or(range.start, |i| range.start + i);
    let is_removed = move |&i: &usize| {
        let is_at_end = if kind == RemovalKind::Front {
            model.edits().is_removed_at_front(i)
        } else {
            i > last_remaining
        };
        is_at_end && model.index_removal_lods()[i] == lod
    };
    range
        .filter(is_removed)
        .map(move |i| model.simplified.collapses().resolve(model.strips.indices()[i], Lod(lod)))
}

impl Speed {
    /// Returns whether going through the changes between two LODs is less work than making all
    /// strips anew, and no thread loops longer than it may.
    fn is_near(&self, from: Lod, to: Lod) -> bool {
        let records = from.min(to).0..from.max(to).0;
        if u64::from(self.edits().visits(&records)) * INDICES_PER_ENTRY
            > self.strips.separate_indices()
        {
            return false;
        }
        let mut loops = vec![0u64; self.strips.len()];
        for event in records.flat_map(|record| self.events(record)) {
            let (strip, removals) = (event.strip as usize, event.removals.len() as u64);
            // Every removal may move the whole strip behind it.
            let moved =
                if removals > 0 { 2 * removals + self.strips.range(strip).len() as u64 } else { 0 };
            loops[strip] += 1 + event.changes.len() as u64 + moved;
        }
        loops.into_iter().all(|loops| loops <= u64::from(LONGEST_LOOP))
    }

    /// The model over some LODs, each compared in full: packed strips and draw arguments with the
    /// CPU, the triangles of the CPU with the reference.
    ///
    /// # Errors
    /// If a strip is longer than a kernel may loop.
    pub fn replay<'a>(
        &'a self,
        stops: Vec<Lod>,
        reference: &'a Reference<'_>,
    ) -> Result<Plan<'a>, PlanError> {
        let mut program = Program::default();
        let device = Device::new(&mut program, self)?;
        let (drawn, strip_states, strips) =
            (device.packed.drawn, device.strip_states, device.strips);
        let locate = move |buffer, word: usize| {
            if buffer == drawn {
                format!("index {word} of all that are drawn")
            } else if buffer == strip_states {
                format!("strip {} of submesh {}", word / 2, self.submesh_of(word / 2))
            } else {
                format!("word {word}")
            }
        };
        let mut cursor = self.cursor();
        let moves = stops.into_iter().map(move |lod| {
            let lod = self.simplified.collapses().floor(lod);
            let passes = device.passes(self, cursor.lod(), lod);
            let difference = move_and_compare(self, &mut cursor, lod, reference);
            let checks = device.packed.expected(&self.strips, |strip| cursor.strip(strip)).to_vec();
            Step::show(lod, passes, checks, difference)
        });
        Ok(Plan::of_moves([self.name(), "direct"], program, &[strips, strip_states], moves, locate))
    }
}
