//! The degenerate filter: ordered compaction of the triangles that are drawn (the thesis uses a geometry shader).

use crate::interactive::shaders;
use crate::plan::{BufferId, KernelId, Pass, Program, Scan};
use lodc_mesh::{Mesh, position_key};

/// Buffers and kernels of the filter.
#[derive(Clone, Debug)]
pub struct Filter {
    /// The triangles that are filtered.
    pub triangles: BufferId,
    vertices: BufferId,
    submeshes: BufferId,
    live: BufferId,
    blocks: BufferId,
    /// Corners of the triangles that are drawn.
    pub indices: BufferId,
    /// Arguments of one indirect draw per submesh.
    pub draws: BufferId,
    count: KernelId,
    write: KernelId,
    arguments: KernelId,
    scan: Scan,
    sizes: [u32; 3],
}

impl Filter {
    /// Prepares filtering `triangles` (submesh by submesh, in any order within) by the positions of `vertices`, records of
    /// `stride` words.
    pub fn new(program: &mut Program, mesh: &Mesh, triangles: &[[u32; 3]], vertices: BufferId, stride: usize) -> Self {
        let ranges: Vec<u32> = mesh.submeshes().iter().flat_map(|s| [s.first_triangle, s.triangle_count]).collect();
        // The last block is empty: after the prefix sums it holds the number of all.
        let count = triangles.len().div_ceil(1024) + 1;
        let blocks = program.zeros("blocks", count);
        Self {
            triangles: program.words("triangles", triangles.as_flattened()),
            vertices,
            submeshes: program.words("submeshes", ranges),
            live: program.zeros("live", triangles.len().div_ceil(4)),
            blocks,
            indices: program.zeros("indices", 3 * triangles.len()),
            draws: program.zeros("draws", 5 * mesh.submeshes().len()),
            count: program.kernel(shaders::FILTER_COUNT),
            write: program.kernel(shaders::FILTER_WRITE),
            arguments: program.kernel(shaders::FILTER_DRAWS),
            scan: Scan::new(program, blocks, count),
            sizes: [triangles.len() as u32, stride as u32, mesh.submeshes().len() as u32],
        }
    }

    /// The passes.
    #[must_use]
    pub fn passes(&self) -> Vec<Pass> {
        let [triangles, stride, submeshes] = self.sizes;
        // Prefix sums work in place: what the last run left in the empty block at the end is its total.
        let threads = triangles.div_ceil(4);
        let count = Pass {
            kernel: self.count,
            buffers: vec![self.triangles, self.vertices, self.live, self.blocks],
            threads,
            parameters: vec![triangles, stride],
        };
        let write = Pass {
            kernel: self.write,
            buffers: vec![self.triangles, self.live, self.blocks, self.indices],
            threads,
            parameters: vec![triangles],
        };
        let arguments = Pass {
            kernel: self.arguments,
            buffers: vec![self.submeshes, self.live, self.blocks, self.draws],
            threads: submeshes,
            parameters: vec![submeshes],
        };
        std::iter::once(count).chain(self.scan.passes()).chain([write, arguments]).collect()
    }
}

/// The same on the CPU: corners of the triangles that are drawn, and the arguments of the draws.
#[must_use]
pub fn filtered(mesh: &Mesh, triangles: &[[u32; 3]], vertices: &[u32], stride: usize) -> (Vec<u32>, Vec<u32>) {
    let key = |v: u32| {
        let at = v as usize * stride;
        position_key([vertices[at], vertices[at + 1], vertices[at + 2]].map(f32::from_bits))
    };
    let (mut indices, mut draws) = (Vec::new(), Vec::new());
    for submesh in mesh.submeshes() {
        let first = indices.len();
        for t in &triangles[submesh.triangles()] {
            let [a, b, c] = t.map(key);
            if a != b && b != c && c != a {
                indices.extend(t);
            }
        }
        draws.extend([(indices.len() - first) as u32, 1, first as u32, 0, 0]);
    }
    (indices, draws)
}
