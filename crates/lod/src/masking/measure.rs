//! What is timed of Masking Strips on a graphics device: moves over all LODs, and draws.

use super::{Masking, replay::Device};
use lodc_mesh::Lod;
use lodc_plan::{
    Benchmark, Case, Memory, PlanError, Program, VertexRecords, drawn_stops, timed_updates,
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
        let passes = |_, to| device.passes(to);
        let shown = drawn_stops(&self.simplified).into_iter().skip(1);
        let shown = shown.map(|lod| device.passes(lod)).collect();
        let drawing = device.packed().drawing(positions, mesh.bounds());
        let cases = vec![
            Case::updates("masks, linear sweep", &timed_updates(&self.simplified), passes),
            // What has to be done however little changes.
            Case::new("masks, standing still", vec![device.passes(Lod(0)); 8], 0),
            Case::drawing("draw, over the LODs", shown, drawing),
        ];
        let (positions, normals) = program.words_with_normals(mesh.vertex_count());
        let memory = vec![Memory { variant: "masks", positions, normals }];
        Ok(Benchmark { program, setup: Vec::new(), cases, memory })
    }
}
