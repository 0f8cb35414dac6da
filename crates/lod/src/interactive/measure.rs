//! Cases of Interactive Meshes to time on a device (thesis 5.5.4), positions only, as the thesis
//! counts.

use super::view::{Criterion, Filter, ViewPasses, ViewQuery, Views};
use super::{CollapseLists, Continuous, Counting, Interactive, replay};
use lodc_mesh::{Lod, Simplified};
use lodc_model::Model;
use lodc_plan::{
    Benchmark, BufferId, Case, DrawInput, Memory, Pass, PlanError, Program, VertexRecords,
    drawn_stops, timed_updates,
};
use lodc_strip::order;

impl Interactive {
    /// Construction, continuous extraction over the linear sweep and in jumps across the whole
    /// range, view-dependent extraction from eight eyes with and without the filter, the filter
    /// alone, and draws.
    ///
    /// # Errors
    /// If the mesh is too large or its lists too long.
    pub fn benchmark(&self) -> Result<Benchmark, PlanError> {
        let simplified = self.simplified().as_ref();
        let mesh = simplified.mesh();
        let lists = replay::lists(simplified)?;
        let memory = memory(simplified, &lists)?;
        let records = VertexRecords::positions(mesh);
        let mut program = Program::default();
        let base = Continuous::new(&mut program, simplified, &lists, &records)?;
        let counting = Counting::new(&mut program, mesh, base.vertices, &records);
        let views = Views::new(simplified, records);
        let dependent = ViewPasses::new(&mut program, &views, base.source, base.vertices);
        let filter = Filter::new(&mut program, mesh, &order(mesh, 16), base.vertices, 3);
        let setup = base.construction();
        let passes = Passes { simplified, base, counting, dependent, filter };
        let mut cases = passes.continuous();
        cases.extend(passes.view_dependent());
        Ok(Benchmark { program, memory, setup, cases })
    }
}

/// The passes of one program that cases are put together from.
struct Passes<'a> {
    simplified: &'a Simplified,
    base: Continuous,
    counting: Counting,
    dependent: ViewPasses,
    filter: Filter,
}

impl Passes<'_> {
    /// Construction, extraction over all LODs, and draws of them.
    fn continuous(&self) -> Vec<Case> {
        let (base, counting) = (&self.base, &self.counting);
        let extraction = |from, to| vec![base.extraction(from, to)];
        let updates = timed_updates(self.simplified);
        let coarse = self.coarse();
        let jumps = [[Lod(0), coarse], [coarse, Lod(0)]].repeat(4);
        let shown = drawn_stops(self.simplified)
            .windows(2)
            .map(|pair| vec![base.extraction(pair[0], pair[1]), counting.pass()])
            .collect();
        let drawn = self.drawn(counting.triangles, counting.draws);
        vec![
            Case::new("construction", vec![base.construction()], self.vertices()),
            Case::updates("continuous, linear sweep", &updates, extraction),
            Case::updates("continuous, whole mesh", &jumps, extraction),
            Case::new("live count", vec![vec![counting.pass()]; 8], 8 * self.vertices()),
            Case::drawing("draw, over the LODs", shown, drawn),
        ]
    }

    /// Views from eight eyes, the filter, and draws of what it leaves.
    fn view_dependent(&self) -> Vec<Case> {
        let coarse = self.coarse();
        let outline = |eye| Criterion::Silhouette { eye, edge: Lod(0), face: coarse, width: 1.0 };
        // One pixel of a thousand.
        let error = |eye| Criterion::ScreenError { eye, slope: Criterion::slope(1.0, 1000.0, 0.5) };
        let outlines = |morph| self.views_by(&outline, morph);
        let filtered = || -> Vec<Vec<Pass>> {
            let with_filter = |passes: Vec<Pass>| [passes, self.filter.passes()].concat();
            outlines(false).into_iter().map(with_filter).collect()
        };
        let all = 8 * self.vertices();
        let drawn = self.drawn(self.filter.indices, self.filter.draws);
        let everything = vec![vec![self.dependent.pass(&lod_0_everywhere())]];
        vec![
            Case::new("view-dependent", outlines(false), all),
            Case::new("view-dependent, morphing", outlines(true), all),
            Case::new("view-dependent, error", self.views_by(&error, false), all),
            Case::new("degenerate filter alone", vec![self.filter.passes(); 8], all),
            Case::new("view-dependent, filtered", filtered(), all),
            Case::drawing("draw, filtered", filtered(), drawn),
            // Views leave no pointers: back to LOD 0.
            Case::new("all to LOD 0", everything, self.vertices()),
        ]
    }

    fn vertices(&self) -> u64 {
        self.simplified.mesh().vertex_count() as u64
    }

    /// A LOD after nearly all records, so that every vertex is looked at and nearly every one is
    /// rewritten.
    fn coarse(&self) -> Lod {
        let collapses = self.simplified.collapses();
        collapses.floor(Lod((u64::from(collapses.last().0) * 99 / 100) as u32))
    }

    /// One view from each of eight eyes.
    fn views_by(&self, criterion: &dyn Fn([f32; 3]) -> Criterion, morph: bool) -> Vec<Vec<Pass>> {
        let query = |eye| ViewQuery { criterion: criterion(eye), morph };
        let around = eyes(self.simplified.mesh().bounds());
        around.iter().map(|&eye| vec![self.dependent.pass(&query(eye))]).collect()
    }

    fn drawn(&self, indices: BufferId, draws: BufferId) -> DrawInput {
        let mesh = self.simplified.mesh();
        DrawInput {
            vertices: self.base.vertices,
            stride: 3,
            indices,
            strips: false,
            draws,
            first: 0,
            count: mesh.submeshes().len(),
            bounds: mesh.bounds(),
        }
    }
}

fn lod_0_everywhere() -> ViewQuery {
    ViewQuery { criterion: Criterion::everywhere(Lod(0)), morph: false }
}

/// Returns the memory of the variants, each by itself.
fn memory(simplified: &Simplified, lists: &CollapseLists) -> Result<Vec<Memory>, PlanError> {
    let mesh = simplified.mesh();
    let words = |stride, variant: &dyn Fn(&mut Program, VertexRecords) -> Result<(), PlanError>| {
        let mut program = Program::default();
        variant(
            &mut program,
            VertexRecords { stride, place: 0, words: vec![0; stride * mesh.vertex_count()] },
        )?;
        Ok(program.size())
    };
    let continuous = |program: &mut Program, records: VertexRecords| {
        let base = Continuous::new(program, simplified, lists, &records)?;
        Counting::new(program, mesh, base.vertices, &records);
        Ok(())
    };
    let dependent = |program: &mut Program, records: VertexRecords, filtered| {
        let stride = records.stride;
        // Positions are in the points: only other attributes are read from the records.
        let source =
            program.zeros("source", if stride > 3 { stride * mesh.vertex_count() } else { 0 });
        let vertices = program.zeros("vertices", stride * mesh.vertex_count());
        ViewPasses::new(program, &Views::new(simplified, records), source, vertices);
        if filtered {
            Filter::new(program, mesh, mesh.triangles(), vertices, stride);
        } else {
            program.zeros("triangles", 3 * mesh.triangles().len());
        }
        Ok(())
    };
    let of_variant =
        |variant, make: &dyn Fn(&mut Program, VertexRecords) -> Result<(), PlanError>| {
            Ok(Memory { variant, positions: words(3, make)?, normals: words(6, make)? })
        };
    Ok(vec![
        of_variant("continuous", &continuous)?,
        of_variant("view-dependent", &|program, records| dependent(program, records, false))?,
        of_variant("view-dependent, filtered", &|program, records| {
            dependent(program, records, true)
        })?,
    ])
}

/// Eight points around a box, at the corners of one three times as large.
fn eyes((low, high): ([f32; 3], [f32; 3])) -> [[f32; 3]; 8] {
    std::array::from_fn(|corner| {
        std::array::from_fn(|axis| {
            let half = (high[axis] - low[axis]) / 2.0;
            let sign = if corner >> axis & 1 == 0 { -3.0 } else { 3.0 };
            f32::midpoint(low[axis], high[axis]) + sign * half.max(1e-6)
        })
    })
}
