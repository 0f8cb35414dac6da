//! Many instances of an Interactive Mesh that stay on a graphics device, for hosts: each has a
//! level of its own, and two passes move as many of them as move in a frame.

use super::{replay, shaders};
use lodc_mesh::{Lod, Simplified};
use lodc_plan::{BufferId, DrawInput, KernelId, Pass, PlanError, Program, VertexRecords};

/// An instance that moves to another level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Move {
    /// Which one.
    pub instance: u32,
    /// Where it is.
    pub from: Lod,
    /// The end of a step.
    pub to: Lod,
}

/// Instances of one object, each at one level everywhere. All share the index buffer; the draws of
/// an instance are indirect, of records that begin at its base vertex.
#[derive(Clone, Debug)]
pub struct ResidentMany {
    /// Buffers and kernels.
    pub program: Program,
    /// The records of LOD 0, which are copied to the second buffer once for each instance.
    pub repeated: [BufferId; 2],
    /// The table of moves, written before each pair of passes.
    pub table: BufferId,
    /// The draws of all instances, in order.
    drawn: DrawInput,
    offsets: BufferId,
    entries: BufferId,
    current: BufferId,
    error_flag: BufferId,
    submeshes: BufferId,
    extract: KernelId,
    live: KernelId,
    /// Vertices and submeshes of the mesh.
    counts: [u32; 2],
}

impl ResidentMany {
    /// Lays out `instances` instances of an object, with all its attributes. Moves of all of them
    /// from LOD 0 to LOD 0 make the first draws.
    ///
    /// # Errors
    /// If the mesh is too large for so many, or its lists too long.
    pub fn new(simplified: &Simplified, instances: u32) -> Result<Self, PlanError> {
        let (mesh, lists) = (simplified.mesh(), replay::lists(simplified)?);
        replay::checked_depth(&lists)?;
        let records = VertexRecords::whole(mesh)?;
        let all = records.words.len() as u64 * u64::from(instances);
        if all > u64::from(u32::MAX) / 4 {
            return Err(PlanError::TooLarge { what: "the records of all instances", words: all });
        }
        let count = instances as usize;
        let mut program = Program::default();
        let (stride, place) = (records.stride, records.place as u32);
        let source = program.words("source", records.words);
        let vertices = program.zeros("vertices of instances", all as usize);
        let ranges: Vec<u32> =
            mesh.submeshes().iter().flat_map(|s| [s.first_triangle, s.triangle_count]).collect();
        let counts = [mesh.vertex_count() as u32, mesh.submeshes().len() as u32];
        let constants = if place == 0 { vec![] } else { vec![("place", place)] };
        let drawn = DrawInput {
            vertices,
            stride,
            indices: program.words("triangles", mesh.triangles().as_flattened()),
            strips: false,
            draws: program.zeros("draws", 5 * mesh.submeshes().len() * count),
            first: 0,
            count: mesh.submeshes().len(),
            bounds: mesh.bounds(),
        };
        Ok(Self {
            repeated: [source, vertices],
            table: program.zeros("moves", 4 * count),
            drawn,
            offsets: program.words("offsets", lists.offsets()),
            entries: program.words("entries", lists.entries()),
            current: program.zeros("current", mesh.vertex_count() * count),
            error_flag: program.zeros("error_flag", 1),
            submeshes: program.words("submeshes", ranges),
            extract: program.kernel(shaders::EXTRACT_MANY),
            live: program.kernel_with(shaders::LIVE_MANY, &constants),
            counts,
            program,
        })
    }

    /// The words of the table of moves, and the passes that make them; nothing if there are no
    /// moves. More than one table only if threads could not be numbered otherwise: each is written
    /// before its passes.
    #[must_use]
    pub fn moves(&self, moves: &[Move]) -> Vec<(Vec<u32>, [Pass; 2])> {
        let [vertices, submeshes] = self.counts;
        let at_once = u32::MAX / 2 / vertices.max(submeshes).max(1);
        moves.chunks(at_once.max(1) as usize).map(|moves| self.moves_at_once(moves)).collect()
    }

    fn moves_at_once(&self, moves: &[Move]) -> (Vec<u32>, [Pass; 2]) {
        let [vertices, _] = self.counts;
        let mut threads = 0;
        let mut table = Vec::with_capacity(4 * moves.len());
        for m in moves {
            table.extend([threads, m.instance, m.to.0, 0]);
            threads += m.from.max(m.to).0.min(vertices);
        }
        let [source, drawn] = self.repeated;
        let buffers = vec![
            self.offsets,
            self.entries,
            source,
            self.table,
            self.current,
            drawn,
            self.error_flag,
        ];
        let parameters = vec![moves.len() as u32, threads, vertices, self.drawn.stride as u32];
        let extract = Pass { kernel: self.extract, buffers, threads, parameters };
        (table, [extract, self.live(moves.len() as u32)])
    }

    /// The draws of one instance.
    #[must_use]
    pub fn drawn(&self, instance: usize) -> DrawInput {
        DrawInput { first: instance * self.drawn.count, ..self.drawn }
    }

    fn live(&self, moves: u32) -> Pass {
        let [vertices, submeshes] = self.counts;
        Pass {
            kernel: self.live,
            buffers: vec![
                self.submeshes,
                self.drawn.indices,
                self.repeated[1],
                self.table,
                self.drawn.draws,
            ],
            threads: moves * submeshes,
            parameters: vec![moves, submeshes, vertices, self.drawn.stride as u32],
        }
    }
}
