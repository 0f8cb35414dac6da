//! What is timed of Speed Strips (strips that are edited from level to level) on a graphics device:
//! moves over all LODs, and draws. All are *direct*: a kernel writes the strips of a LOD from those
//! of the LOD before.

use super::{Speed, replay::Device};
use lodc_mesh::Lod;
use lodc_plan::{
    Benchmark, Case, Memory, PlanError, Program, VertexRecords, drawn_stops, timed_updates,
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
        let passes = |from, to| device.passes(self, from, to);
        let shown = drawn_stops(&self.simplified);
        let shown = shown.windows(2).map(|pair| passes(pair[0], pair[1])).collect();
        let drawing = device.packed().drawing(positions, mesh.bounds());
        let cases = vec![
            Case::updates("direct, linear sweep", &timed_updates(&self.simplified), passes),
            // What has to be done however little changes.
            Case::new("direct, standing still", vec![passes(Lod(0), Lod(0)); 8], 0),
            Case::drawing("draw, over the LODs", shown, drawing),
        ];
        let (positions, normals) = program.words_with_normals(mesh.vertex_count());
        let memory = vec![Memory { variant: "direct", positions, normals }];
        Ok(Benchmark { program, setup: Vec::new(), cases, memory })
    }
}
