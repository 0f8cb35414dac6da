//! Cases of Interactive Meshes to time on a device (thesis 5.5.4), positions only, as the thesis
//! counts.

use super::view::{Criterion, Filter, ViewPasses, ViewQuery, Views};
use super::{CollapseLists, Continuous, Counting, Interactive, replay};
use lodc_mesh::{Lod, Mesh, Simplified};
use lodc_model::Model;
use lodc_plan::{
    Benchmark, Case, DRAWS, Drawn, Memory, Pass, PlanError, Program, SWEEP, VertexRecords, sweep,
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
        let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
        let lists = replay::lists(simplified)?;
        let memory = memory(simplified, &lists)?;
        let records = VertexRecords::positions(mesh);
        let mut program = Program::default();
        let base = Continuous::new(&mut program, simplified, &lists, &records)?;
        let counting = Counting::new(&mut program, mesh, base.vertices, records.stride);
        let views = Views::new(simplified, records);
        let dependent = ViewPasses::new(&mut program, &views, base.source, base.vertices);
        let filter = Filter::new(&mut program, mesh, &order(mesh, 16), base.vertices, 3);

        let last = collapses.last().0;
        let moves = |stops: &[Lod]| {
            stops.windows(2).map(|pair| vec![base.extraction(pair[0], pair[1])]).collect()
        };
        let steps = sweep(collapses, SWEEP);
        let touched = steps.windows(2).map(|pair| u64::from(pair[0].max(pair[1]).0)).sum();
        // One entry and nearly all of them, so that every vertex is looked at and nearly every one
        // is rewritten.
        let coarse = collapses.floor(Lod((u64::from(last) * 99 / 100) as u32));
        let jumps: Vec<Lod> = (0..9).map(|i| if i % 2 == 0 { Lod(0) } else { coarse }).collect();
        let whole = 8 * u64::from(coarse.0);
        let stops = sweep(collapses, DRAWS);
        let shown = stops
            .windows(2)
            .map(|pair| vec![base.extraction(pair[0], pair[1]), counting.pass()])
            .collect();

        let around = eyes(mesh.bounds());
        let views_by =
            |criterion: &dyn Fn([f32; 3]) -> Criterion, morph, filtered: bool| -> Vec<Vec<Pass>> {
                let passes = |eye| {
                    let view =
                        dependent.pass(&ViewQuery { criterion: criterion(eye), morph }, &views);
                    let filter = if filtered { filter.passes() } else { Vec::new() };
                    std::iter::once(view).chain(filter).collect()
                };
                around.iter().map(|&eye| passes(eye)).collect()
            };
        let outline = |eye| Criterion::Silhouette { eye, edge: Lod(0), face: coarse };
        // One pixel of a thousand.
        let error = |eye| Criterion::ScreenError { eye, slope: Criterion::slope(1.0, 1000.0, 0.5) };
        let all = 8 * mesh.vertex_count() as u64;
        let drawing = |indices, draws| Drawn {
            vertices: base.vertices,
            stride: 3,
            indices,
            strips: false,
            draws,
            count: mesh.submeshes().len(),
            bounds: mesh.bounds(),
        };
        let cases = vec![
            Case::new("construction", vec![base.construction()], mesh.vertex_count() as u64),
            Case::new("continuous, linear sweep", moves(&steps), touched),
            Case::new("continuous, whole mesh", moves(&jumps), whole),
            Case::new("live count", vec![vec![counting.pass()]; 8], all),
            Case::drawing(
                "draw, over the LODs",
                shown,
                drawing(counting.triangles, counting.draws),
            ),
            Case::new("view-dependent", views_by(&outline, false, false), all),
            Case::new("view-dependent, morphing", views_by(&outline, true, false), all),
            Case::new("view-dependent, error", views_by(&error, false, false), all),
            Case::new("degenerate filter alone", vec![filter.passes(); 8], all),
            Case::new("view-dependent, filtered", views_by(&outline, false, true), all),
            Case::drawing(
                "draw, filtered",
                views_by(&outline, false, true),
                drawing(filter.indices, filter.draws),
            ),
            // Views leave no pointers: back to LOD 0.
            Case::new("all to LOD 0", vec![vec![dependent.pass(&everything(), &views)]], all / 8),
        ];
        Ok(Benchmark { program, memory, setup: base.construction(), cases })
    }
}

/// LOD 0 everywhere.
fn everything() -> ViewQuery {
    ViewQuery { criterion: Criterion::everywhere(Lod(0)), morph: false }
}

/// Returns the memory of the variants, each by itself.
fn memory(simplified: &Simplified, lists: &CollapseLists) -> Result<Vec<Memory>, PlanError> {
    let mesh = simplified.mesh();
    let words = |stride, variant: &dyn Fn(&mut Program, VertexRecords) -> Result<(), PlanError>| {
        let mut program = Program::default();
        variant(
            &mut program,
            VertexRecords { stride, words: vec![0; stride * mesh.vertex_count()] },
        )?;
        Ok(program.size())
    };
    let continuous = |program: &mut Program, records: VertexRecords| {
        let base = Continuous::new(program, simplified, lists, &records)?;
        Counting::new(program, mesh, base.vertices, records.stride);
        Ok(())
    };
    let filter = |program: &mut Program, mesh: &Mesh, records: VertexRecords, filtered| {
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
    let of = |variant, make: &dyn Fn(&mut Program, VertexRecords) -> Result<(), PlanError>| {
        Ok(Memory { variant, positions: words(3, make)?, normals: words(6, make)? })
    };
    Ok(vec![
        of("continuous", &continuous)?,
        of("view-dependent", &|program, records| filter(program, mesh, records, false))?,
        of("view-dependent, filtered", &|program, records| filter(program, mesh, records, true))?,
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
