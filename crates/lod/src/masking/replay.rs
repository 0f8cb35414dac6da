//! Masking Strips on a graphics device as a [`Plan`]: masks applied and filtered copies compacted,
//! nothing read back.

use super::history::Entry;
use super::updates::whole_strip;
use super::{Cursor, Masking};
use crate::cpu::move_and_compare;
use lodc_mesh::Lod;
use lodc_model::Model;
use lodc_plan::{
    BufferId, Expected, KernelId, LONGEST_LOOP, PackedStrips, Pass, Plan, PlanError, Program, SCAN,
    SCAN_ADD, STRIP_DRAWS, Shader, Step,
};
use lodc_verify::Reference;

const MASKS: Shader = Shader { name: "masks", wgsl: include_str!("masks.wgsl") };
const MASKS_WRITE: Shader = Shader { name: "masks_write", wgsl: include_str!("masks_write.wgsl") };

/// The kernels, for replay and for engines.
pub const SHADERS: [Shader; 5] = [MASKS, SCAN, SCAN_ADD, MASKS_WRITE, STRIP_DRAWS];

/// Buffers and kernels; the bindings in masks.wgsl say what each buffer holds.
#[derive(Clone, Debug)]
pub(super) struct Device {
    starts: BufferId,
    entry_starts: BufferId,
    entries: BufferId,
    collapse_to: BufferId,
    full: BufferId,
    states: BufferId,
    error_flag: BufferId,
    packed: PackedStrips,
    masks: KernelId,
    write: KernelId,
    strips: u32,
}

impl Device {
    /// The strips as they are drawn.
    pub(super) fn packed(&self) -> &PackedStrips {
        &self.packed
    }

    pub(super) fn new(program: &mut Program, model: &Masking) -> Result<Self, PlanError> {
        let longest =
            model.entry_starts.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
        // Every entry also loops over the positions in its mask, usually a few of 16: a quarter is
        // chosen by hand.
        let most = LONGEST_LOOP / 4;
        if longest > most {
            let what = "a strip with its edits";
            return Err(PlanError::TooDeep { what, rounds: longest, most });
        }
        let strips = model.strips.len();
        let masks = |e: &Entry| u32::from(e.positions) | u32::from(e.filter) << 16;
        let entries = model.entries.iter().flat_map(|e| [e.record, masks(e)]);
        let starts =
            (0..strips).map(|s| model.strips.range(s).start).chain([model.strips.indices().len()]);
        let states: Vec<u32> =
            model.entry_starts[..strips].iter().flat_map(|&first| [first, 0]).collect();
        Ok(Self {
            starts: program.words("starts", starts.map(|start| start as u32).collect::<Vec<_>>()),
            entry_starts: program.words("entry_starts", model.entry_starts.as_slice()),
            entries: program.words("entries", entries.collect::<Vec<_>>()),
            collapse_to: program.words("collapse_to", model.simplified.collapses().targets()),
            full: program.words("full", model.strips.indices()),
            states: program.words("states", states),
            error_flag: program.zeros("error_flag", 1),
            packed: PackedStrips::new(program, &model.strips),
            masks: program.kernel(MASKS),
            write: program.kernel(MASKS_WRITE),
            strips: strips as u32,
        })
    }

    /// Shows a LOD, whatever was shown before.
    pub(super) fn passes(&self, lod: Lod) -> Vec<Pass> {
        let masks = Pass {
            kernel: self.masks,
            buffers: vec![
                self.starts,
                self.entry_starts,
                self.entries,
                self.collapse_to,
                self.full,
                self.states,
                self.packed.offsets,
                self.error_flag,
            ],
            threads: self.strips,
            parameters: vec![self.strips, lod.0],
        };
        let write = Pass {
            kernel: self.write,
            buffers: vec![
                self.starts,
                self.full,
                self.states,
                self.packed.offsets,
                self.packed.drawn,
            ],
            threads: self.strips,
            parameters: vec![self.strips],
        };
        std::iter::once(masks).chain(self.packed.around(write)).collect()
    }
}

impl Masking {
    /// The model over some LODs, each compared in full: full strips, masks, packed strips and draw
    /// arguments with the CPU, and the triangles of the CPU with the reference.
    ///
    /// # Errors
    /// If a strip changes too often for a kernel.
    pub fn replay<'a>(
        &'a self,
        stops: Vec<Lod>,
        reference: &'a Reference<'_>,
    ) -> Result<Plan<'a>, PlanError> {
        let mut program = Program::default();
        let device = Device::new(&mut program, self)?;
        let (full, states, drawn) = (device.full, device.states, device.packed.drawn);
        let locate = move |buffer, word: usize| {
            if buffer == full {
                let strip = (0..self.strips.len()).find(|&s| self.strips.range(s).contains(&word));
                format!(
                    "strip {} of submesh {}",
                    strip.unwrap_or(0),
                    self.submeshes[strip.unwrap_or(0)]
                )
            } else if buffer == states {
                format!("strip {}", word / 2)
            } else if buffer == drawn {
                format!("index {word} of all that are drawn")
            } else {
                format!("word {word}")
            }
        };
        let (mut cursor, mut cpu) = (self.cursor(), CpuVersion::new(self));
        let moves = stops.into_iter().map(move |lod| {
            let lod = self.simplified.collapses().floor(lod);
            let difference = move_and_compare(self, &mut cursor, lod, reference);
            cpu.seek(self, lod);
            Step::show(lod, device.passes(lod), cpu.checks(self, &device, &cursor), difference)
        });
        Ok(Plan::of_moves([self.name(), "masks"], program, &[full, states], moves, locate))
    }
}

/// The CPU code that does the same as the kernel `masks`, with the state that the kernel keeps from
/// move to move: full strips to which position masks are applied one by one.
#[derive(Debug)]
struct CpuVersion {
    full: Vec<u32>,
    /// Two words for each strip: its first entry that is not applied, and its filter mask.
    states: Vec<u32>,
}

impl CpuVersion {
    fn new(model: &Masking) -> Self {
        let states =
            model.entry_starts[..model.strips.len()].iter().flat_map(|&first| [first, 0]).collect();
        Self { full: model.strips.indices().to_vec(), states }
    }

    /// The words that a device must hold where the CPU version and the cursor are.
    fn checks(&self, model: &Masking, device: &Device, cursor: &Cursor) -> Vec<Expected> {
        let mut checks = vec![
            Expected::new(device.full, self.full.as_slice()),
            Expected::new(device.states, self.states.as_slice()),
            Expected::new(device.error_flag, [0]),
        ];
        checks.extend(device.packed.expected(&model.strips, |strip| cursor.strip(strip)));
        checks
    }

    fn seek(&mut self, model: &Masking, lod: Lod) {
        let targets = model.simplified.collapses().targets();
        for strip in 0..model.strips.len() {
            let history = model.history(strip);
            let full_strip = &mut self.full[model.strips.range(strip)];
            let mut put = |entry: &Entry, vertex: u32| {
                let masked = full_strip
                    .iter_mut()
                    .enumerate()
                    .filter(|(at, _)| entry.positions >> at & 1 == 1);
                masked.for_each(|(_, v)| *v = vertex);
            };
            let mut next = self.states[2 * strip] as usize;
            while next < history.end && model.entries[next].record < lod.0 {
                put(&model.entries[next], targets[model.entries[next].record as usize]);
                next += 1;
            }
            while next > history.start && model.entries[next - 1].record >= lod.0 {
                next -= 1;
                put(&model.entries[next], model.entries[next].record);
            }
            let whole = whole_strip(full_strip.len());
            let filter = if next > history.start { model.entries[next - 1].filter } else { whole };
            self.states[2 * strip..][..2].copy_from_slice(&[next as u32, u32::from(filter)]);
        }
    }
}
