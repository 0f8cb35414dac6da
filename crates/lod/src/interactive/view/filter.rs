//! The degenerate filter: compacts the triangles that have an area, in order, into the index buffer
//! that is drawn (the thesis uses a geometry shader). On a device and, for comparison, on the CPU.

use crate::interactive::shaders;
use lodc_mesh::{Mesh, position_key};
use lodc_plan::{BufferId, KernelId, Pass, Program, Scan};

/// Buffers and kernels of the filter.
#[derive(Clone, Debug)]
pub struct Filter {
    /// The triangles that are filtered.
    pub triangles: BufferId,
    vertices: BufferId,
    submeshes: BufferId,
    /// A word per eight triangles: bit `j` is 1 if the `j`-th of them is drawn.
    live: BufferId,
    /// Per eight triangles the number of triangles that are drawn before them; then that of all.
    pub drawn_before: BufferId,
    /// Corners of the triangles that are drawn.
    pub indices: BufferId,
    /// Arguments of one indirect draw per submesh.
    pub draws: BufferId,
    count: KernelId,
    write: KernelId,
    arguments: KernelId,
    scan: Scan,
    /// Number of eights of triangles, the last filled up.
    eights: u32,
    submesh_count: u32,
}

impl Filter {
    /// Prepares filtering `triangles` (submesh by submesh, in any order within) by the positions of
    /// `vertices`, records of `stride` words.
    pub fn new(
        program: &mut Program,
        mesh: &Mesh,
        triangles: &[[u32; 3]],
        vertices: BufferId,
        stride: usize,
    ) -> Self {
        let ranges: Vec<u32> =
            mesh.submeshes().iter().flat_map(|s| [s.first_triangle, s.triangle_count]).collect();
        let eights = triangles.len().div_ceil(8);
        // Filled up with triangles that are never drawn.
        let mut padded = triangles.as_flattened().to_vec();
        padded.resize(24 * eights, 0);
        let drawn_before = program.zeros("drawn_before", eights + 1);
        Self {
            triangles: program.words("triangles", padded),
            vertices,
            submeshes: program.words("submeshes", ranges),
            live: program.zeros("live", eights),
            drawn_before,
            indices: program.zeros("indices", 3 * triangles.len()),
            draws: program.zeros("draws", 5 * mesh.submeshes().len()),
            count: program.kernel_with(shaders::FILTER_COUNT, &[("stride", stride as u32)]),
            write: program.kernel(shaders::FILTER_WRITE),
            arguments: program.kernel(shaders::FILTER_DRAWS),
            scan: Scan::new(program, drawn_before, eights + 1),
            eights: eights as u32,
            submesh_count: mesh.submeshes().len() as u32,
        }
    }

    /// The passes.
    #[must_use]
    pub fn passes(&self) -> Vec<Pass> {
        let (eights, submeshes) = (self.eights, self.submesh_count);
        let count = Pass {
            kernel: self.count,
            buffers: vec![self.triangles, self.vertices, self.live, self.drawn_before],
            threads: eights + 1,
            parameters: vec![eights],
        };
        let write = Pass {
            kernel: self.write,
            buffers: vec![self.triangles, self.live, self.drawn_before, self.indices],
            threads: eights,
            parameters: vec![eights],
        };
        let arguments = Pass {
            kernel: self.arguments,
            buffers: vec![self.submeshes, self.live, self.drawn_before, self.draws],
            threads: submeshes,
            parameters: vec![submeshes],
        };
        std::iter::once(count).chain(self.scan.passes()).chain([write, arguments]).collect()
    }
}

/// The result of the filter.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filtered {
    /// Corners of the triangles that are drawn.
    pub indices: Vec<u32>,
    /// Arguments of one draw per submesh, five words each.
    pub draws: Vec<u32>,
    /// As [`Filter::drawn_before`].
    pub drawn_before: Vec<u32>,
}

/// Filters: the CPU version of the kernels.
#[must_use]
pub fn filtered(mesh: &Mesh, triangles: &[[u32; 3]], vertices: &[u32], stride: usize) -> Filtered {
    let key = |v: u32| {
        let offset = v as usize * stride;
        position_key(
            [vertices[offset], vertices[offset + 1], vertices[offset + 2]].map(f32::from_bits),
        )
    };
    let mut remaining = Filtered::default();
    for submesh in mesh.submeshes() {
        let first = remaining.indices.len() as u32;
        for t in submesh.triangles() {
            if t % 8 == 0 {
                remaining.drawn_before.push(remaining.indices.len() as u32 / 3);
            }
            let [a, b, c] = triangles[t].map(key);
            if a != b && b != c && c != a {
                remaining.indices.extend(triangles[t]);
            }
        }
        remaining.draws.extend([remaining.indices.len() as u32 - first, 1, first, 0, 0]);
    }
    remaining.drawn_before.push(remaining.indices.len() as u32 / 3);
    remaining
}
