//! What is timed of Masking Strips on a graphics device: moves over all LODs, and draws.

use super::{Masking, replay::Device};
use lodc_mesh::Lod;
use lodc_plan::{
    Benchmark, Case, DRAWN_UPDATES, Memory, PlanError, Program, SWEEP_UPDATES, VertexRecords, sweep,
};

impl Masking {
    /// The linear sweep over all LODs, down and up, and draws on the way.
    ///
    /// # Errors
    /// If a strip changes too often for a kernel.
    pub fn benchmark(&self) -> Result<Benchmark, PlanError> {
        let mesh = self.simplified.mesh();
        let mut program = Program::default();
        let device = Device::new(&mut program, self)?;
        let positions = program.words("positions", VertexRecords::positions(mesh).words);
        let moves = |updates| {
            let stops = sweep(self.simplified.collapses(), updates);
            let runs = stops[1..].iter().map(|&lod| device.passes(lod)).collect();
            (runs, stops.windows(2).map(|pair| u64::from(pair[0].max(pair[1]).0)).sum())
        };
        let (runs, vertices) = moves(SWEEP_UPDATES);
        let drawing = device.packed().drawing(positions, mesh.bounds());
        let cases = vec![
            Case::new("masks, linear sweep", runs, vertices),
            // What has to be done however little changes.
            Case::new("masks, standing still", vec![device.passes(Lod(0)); 8], 0),
            Case::drawing("draw, over the LODs", moves(DRAWN_UPDATES).0, drawing),
        ];
        let (positions, normals) = program.words_with_normals(mesh.vertex_count());
        let memory = vec![Memory { variant: "masks", positions, normals }];
        Ok(Benchmark { program, setup: Vec::new(), cases, memory })
    }
}
