//! An Interactive Mesh that stays on a graphics device, for hosts: uploaded once, shown at any
//! level or by view.

use super::view::{Filter, ViewPasses, ViewQuery, Views};
use super::{Continuous, Counting, replay};
use lodc_mesh::{Lod, Mesh, Simplified};
use lodc_plan::{BufferId, DrawInput, Pass, PlanError, Program, VertexRecords};

/// An object that has one level everywhere.
#[derive(Clone, Debug)]
pub struct Resident {
    /// Buffers and kernels.
    pub program: Program,
    /// Run once, before anything is shown.
    pub setup: Vec<Pass>,
    /// Buffers that every instance has for itself.
    pub instance_buffers: Vec<BufferId>,
    /// The draws.
    pub drawn: DrawInput,
    continuous: Continuous,
    counting: Counting,
}

impl Resident {
    /// Lays an object out, with all its attributes.
    ///
    /// # Errors
    /// If the mesh is too large or its lists too long.
    pub fn new(simplified: &Simplified) -> Result<Self, PlanError> {
        let (mesh, lists) = (simplified.mesh(), replay::lists(simplified)?);
        let records = VertexRecords::whole(mesh)?;
        let mut program = Program::default();
        let continuous = Continuous::new(&mut program, simplified, &lists, &records)?;
        let counting = Counting::new(&mut program, mesh, continuous.vertices, &records);
        let buffers = [continuous.vertices, counting.triangles, counting.draws];
        // At LOD 0 the input itself is drawn.
        let setup = continuous.construction().into_iter().chain([counting.pass()]).collect();
        Ok(Self {
            program,
            setup,
            instance_buffers: [continuous.written().as_slice(), &[counting.draws]].concat(),
            drawn: drawn(mesh, records.stride, buffers),
            continuous,
            counting,
        })
    }

    /// The passes between two LODs, near or far, coarser or finer.
    #[must_use]
    pub fn seek(&self, from: Lod, to: Lod) -> [Pass; 2] {
        [self.continuous.extraction(from, to), self.counting.pass()]
    }
}

/// An object of which every part has a level of its own, by view.
#[derive(Clone, Debug)]
pub struct ResidentView {
    /// Buffers and kernels.
    pub program: Program,
    /// Buffers that every instance has for itself.
    pub instance_buffers: Vec<BufferId>,
    /// The draws.
    pub drawn: DrawInput,
    passes: ViewPasses,
    filter: Filter,
}

impl ResidentView {
    /// Lays an object out, with all its attributes.
    ///
    /// # Errors
    /// If the mesh is too large or collapses too deep.
    pub fn new(simplified: &Simplified) -> Result<Self, PlanError> {
        replay::checked_depth(&replay::lists(simplified)?)?;
        let mesh = simplified.mesh();
        let records = VertexRecords::whole(mesh)?;
        let stride = records.stride;
        let mut program = Program::default();
        let source = program.words("source", records.words.as_slice());
        let vertices = program.words("vertices", records.words.as_slice());
        let views = Views::new(simplified, records);
        let passes = ViewPasses::new(&mut program, &views, source, vertices);
        let filter = Filter::new(&mut program, mesh, mesh.triangles(), vertices, stride);
        let buffers = [vertices, filter.indices, filter.draws];
        let drawn = drawn(mesh, stride, buffers);
        Ok(Self { program, instance_buffers: buffers.to_vec(), drawn, passes, filter })
    }

    /// The passes that show a view.
    #[must_use]
    pub fn show(&self, view: &ViewQuery) -> Vec<Pass> {
        let shown = self.passes.pass(view);
        std::iter::once(shown).chain(self.filter.passes()).collect()
    }
}

fn drawn(mesh: &Mesh, stride: usize, [vertices, indices, draws]: [BufferId; 3]) -> DrawInput {
    let (count, bounds) = (mesh.submeshes().len(), mesh.bounds());
    DrawInput { vertices, stride, indices, strips: false, draws, first: 0, count, bounds }
}
