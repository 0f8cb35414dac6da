//! Strips packed into one index buffer that one draw per submesh shows: one behind the other, each
//! closed by a restart index, those without triangles left out.

use crate::benchmark::DrawInput;
use crate::program::{BufferId, Expected, KernelId, Pass, Program, Shader};
use crate::scan::Scan;
use lodc_mesh::NONE;
use lodc_strip::StripSet;

/// Draw arguments of packed strips.
pub const STRIP_DRAWS: Shader =
    Shader { name: "strip_draws", wgsl: include_str!("strip_draws.wgsl") };

/// The index that closes a strip.
pub const RESTART: u32 = NONE;

/// Buffers and kernels of packed strips.
#[derive(Clone, Debug)]
pub struct Packed {
    submeshes: BufferId,
    /// One word per strip and one more: a pass writes the length of each with its restart index, or
    /// 0; prefix sums make it the offset of each in `drawn`.
    pub places: BufferId,
    /// The packed strips.
    pub drawn: BufferId,
    /// Arguments of one indirect draw per submesh, five words each.
    pub draws: BufferId,
    arguments: KernelId,
    scan: Scan,
    count: u32,
}

impl Packed {
    /// Makes room for strips that are never longer than these.
    pub fn new(program: &mut Program, strips: &StripSet) -> Self {
        let ranges = (0..strips.submesh_count()).map(|s| strips.submesh(s));
        let ranges: Vec<u32> =
            ranges.flat_map(|range| [range.start as u32, range.len() as u32]).collect();
        let places = program.zeros("places", strips.len() + 1);
        Self {
            submeshes: program.words("submeshes", ranges),
            places,
            drawn: program.zeros("drawn", strips.indices().len() + strips.len()),
            draws: program.zeros("draws", 5 * strips.submesh_count()),
            arguments: program.kernel(STRIP_DRAWS),
            scan: Scan::new(program, places, strips.len() + 1),
            count: strips.submesh_count() as u32,
        }
    }

    /// Returns the passes between the pass that writes lengths and `write`, which writes strips to
    /// their offsets; and what follows.
    #[must_use]
    pub fn around(&self, write: Pass) -> Vec<Pass> {
        let arguments = Pass {
            kernel: self.arguments,
            buffers: vec![self.submeshes, self.places, self.draws],
            threads: self.count,
            parameters: vec![self.count],
        };
        self.scan.passes().into_iter().chain([write, arguments]).collect()
    }

    /// Returns their draw, with positions in `vertices`.
    #[must_use]
    pub fn drawing(&self, vertices: BufferId, bounds: ([f32; 3], [f32; 3])) -> DrawInput {
        let count = self.count as usize;
        DrawInput {
            vertices,
            stride: 3,
            indices: self.drawn,
            strips: true,
            draws: self.draws,
            count,
            bounds,
        }
    }

    /// Returns the words that must come out if these strips are drawn, given strip by strip.
    pub fn expected<'a>(
        &self,
        set: &StripSet,
        drawn: impl Fn(usize) -> &'a [u32],
    ) -> [Expected; 3] {
        let (mut indices, mut places, mut draws) = (Vec::new(), vec![0], Vec::new());
        for submesh in 0..set.submesh_count() {
            let first = indices.len() as u32;
            for strip in set.submesh(submesh) {
                let drawn = drawn(strip);
                if !drawn.is_empty() {
                    indices.extend_from_slice(drawn);
                    indices.push(RESTART);
                }
                places.push(indices.len() as u32);
            }
            draws.extend([indices.len() as u32 - first, 1, first, 0, 0]);
        }
        [
            Expected::new(self.drawn, indices),
            Expected::new(self.places, places),
            Expected::new(self.draws, draws),
        ]
    }
}
