//! What is timed of Speed Strips (strips that are edited from level to level) on a graphics device:
//! moves over all LODs, and draws. All are *direct*: a kernel writes the strips of a LOD from those
//! of the LOD before.

use super::{Speed, replay::Device};
use lodc_mesh::Lod;
use lodc_plan::{
    Benchmark, Case, DRAWN_UPDATES, Memory, PlanError, Program, SWEEP_UPDATES, VertexRecords, sweep,
};

impl Speed {
    /// The linear sweep over all LODs, down and up, and draws on the way.
    ///
    /// # Errors
    /// If a strip is longer than a kernel may loop.
    pub fn benchmark(&self) -> Result<Benchmark, PlanError> {
        let mesh = self.simplified.mesh();
        let mut program = Program::default();
        let device = Device::new(&mut program, self)?;
        let positions = program.words("positions", VertexRecords::positions(mesh).words);
        let moves = |updates| {
            let stops = sweep(self.simplified.collapses(), updates);
            // A move looks at every vertex that is gone at the coarser of its two LODs.
            let runs = stops.windows(2).map(|pair| device.passes(self, pair[0], pair[1])).collect();
            (runs, stops.windows(2).map(|pair| u64::from(pair[0].max(pair[1]).0)).sum())
        };
        let (runs, vertices) = moves(SWEEP_UPDATES);
        let drawing = device.packed().drawing(positions, mesh.bounds());
        let cases = vec![
            Case::new("direct, linear sweep", runs, vertices),
            // What has to be done however little changes.
            Case::new("direct, standing still", vec![device.passes(self, Lod(0), Lod(0)); 8], 0),
            Case::drawing("draw, over the LODs", moves(DRAWN_UPDATES).0, drawing),
        ];
        let (positions, normals) = program.words_with_normals(mesh.vertex_count());
        let memory = vec![Memory { variant: "direct", positions, normals }];
        Ok(Benchmark { program, setup: Vec::new(), cases, memory })
    }
}
