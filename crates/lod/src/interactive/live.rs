//! Counts on a device how many triangles of each submesh are drawn. The CPU knows it from the
//! removal LODs ([`Interactive::live`]).
//!
//! [`Interactive::live`]: super::Interactive::live

use super::shaders;
use lodc_mesh::Mesh;
use lodc_plan::{BufferId, KernelId, Pass, Program, VertexRecords};

/// Buffers and the kernel of the count.
#[derive(Clone, Debug)]
pub struct Counting {
    submeshes: BufferId,
    /// Corners of all triangles: the index buffer of the draws.
    pub triangles: BufferId,
    vertices: BufferId,
    /// Arguments of one indirect draw per submesh, five words each.
    pub draws: BufferId,
    live: KernelId,
    submesh_count: u32,
    stride: u32,
}

impl Counting {
    /// Prepares counting by the positions of `vertices`, which are laid out as `records` are.
    pub fn new(
        program: &mut Program,
        mesh: &Mesh,
        vertices: BufferId,
        records: &VertexRecords,
    ) -> Self {
        let ranges: Vec<u32> =
            mesh.submeshes().iter().flat_map(|s| [s.first_triangle, s.triangle_count]).collect();
        Self {
            submeshes: program.words("submeshes", ranges),
            triangles: program.words("triangles", mesh.triangles().as_flattened()),
            vertices,
            draws: program.zeros("draws", 5 * mesh.submeshes().len()),
            live: match records.place {
                0 => program.kernel(shaders::LIVE),
                place => program.kernel_with(shaders::LIVE, &[("place", place as u32)]),
            },
            submesh_count: mesh.submeshes().len() as u32,
            stride: records.stride as u32,
        }
    }

    /// The pass.
    #[must_use]
    pub fn pass(&self) -> Pass {
        Pass {
            kernel: self.live,
            buffers: vec![self.submeshes, self.triangles, self.vertices, self.draws],
            threads: self.submesh_count,
            parameters: vec![self.submesh_count, self.stride],
        }
    }
}
