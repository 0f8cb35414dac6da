//! Strips packed into one index buffer that one draw per submesh shows: one after another, each
//! closed by a restart index; strips without triangles are left out.

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
pub struct PackedStrips {
    /// First strip and number of strips of each submesh.
    submeshes: BufferId,
    /// One word per strip and one more. A pass writes the length of each strip with its restart
    /// index, 0 if it draws nothing; prefix sums make that the offset of each in `drawn`.
    pub offsets: BufferId,
    /// The packed strips.
    pub drawn: BufferId,
    /// Arguments of one indirect draw per submesh, five words each.
    pub draws: BufferId,
    /// [`STRIP_DRAWS`].
    arguments: KernelId,
    /// Prefix sums of `offsets`.
    scan: Scan,
    /// Number of submeshes.
    count: u32,
}

impl PackedStrips {
    /// Adds buffers for strips, each never longer than the one of `strips`, and the kernels.
    pub fn new(program: &mut Program, strips: &StripSet) -> Self {
        let ranges = (0..strips.submesh_count()).map(|s| strips.submesh(s));
        let ranges: Vec<u32> =
            ranges.flat_map(|range| [range.start as u32, range.len() as u32]).collect();
        let offsets = program.zeros("offsets", strips.len() + 1);
        Self {
            submeshes: program.words("submeshes", ranges),
            offsets,
            drawn: program.zeros("drawn", strips.indices().len() + strips.len()),
            draws: program.zeros("draws", 5 * strips.submesh_count()),
            arguments: program.kernel(STRIP_DRAWS),
            scan: Scan::new(program, offsets, strips.len() + 1),
            count: strips.submesh_count() as u32,
        }
    }

    /// Returns the passes that follow the one that writes lengths: prefix sums, `write`, which
    /// writes strips to their offsets, and the arguments of draws.
    #[must_use]
    pub fn around(&self, write: Pass) -> Vec<Pass> {
        let arguments = Pass {
            kernel: self.arguments,
            buffers: vec![self.submeshes, self.offsets, self.draws],
            threads: self.count,
            parameters: vec![self.count],
        };
        self.scan.passes().into_iter().chain([write, arguments]).collect()
    }

    /// Returns the draw of the packed strips, with positions in `vertices`.
    #[must_use]
    pub fn drawing(&self, vertices: BufferId, bounds: ([f32; 3], [f32; 3])) -> DrawInput {
        let count = self.count as usize;
        DrawInput {
            vertices,
            stride: 3,
            indices: self.drawn,
            strips: true,
            draws: self.draws,
            first: 0,
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
        let (mut indices, mut offsets, mut draws) = (Vec::new(), vec![0], Vec::new());
        for submesh in 0..set.submesh_count() {
            let first = indices.len() as u32;
            for strip in set.submesh(submesh) {
                let drawn = drawn(strip);
                if !drawn.is_empty() {
                    indices.extend_from_slice(drawn);
                    indices.push(RESTART);
                }
                offsets.push(indices.len() as u32);
            }
            draws.extend([indices.len() as u32 - first, 1, first, 0, 0]);
        }
        [
            Expected::new(self.drawn, indices),
            Expected::new(self.offsets, offsets),
            Expected::new(self.draws, draws),
        ]
    }
}
