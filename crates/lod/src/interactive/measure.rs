//! What to time of Interactive Meshes on a device (thesis 5.5.4), positions only, as the thesis counts.

use super::view::{Criterion, Filter, View, ViewPasses, Views};
use super::{Continuous, Counting, Interactive, replay};
use crate::Model;
use crate::plan::{Benchmark, Case, Pass, PlanError, Program, VertexRecords, sweep};
use lodc_mesh::Lod;
use lodc_strip::order;

impl Interactive {
    /// Construction, continuous extraction over the linear sweep and in jumps across the whole range, view-dependent
    /// extraction from eight eyes with and without the filter, and the filter alone.
    ///
    /// # Errors
    /// If the mesh is too large or its lists too long.
    pub fn benchmark(&self) -> Result<Benchmark, PlanError> {
        let simplified = self.simplified().as_ref();
        let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
        let lists = replay::lists(simplified)?;
        let records = VertexRecords::positions(mesh);
        let mut program = Program::default();
        let base = Continuous::new(&mut program, simplified, &lists, &records)?;
        let counting = Counting::new(&mut program, mesh, base.vertices, records.stride);
        let continuous = program.bytes() / 4;
        let views = Views::new(simplified, lists, records);
        let dependent = ViewPasses::new(&mut program, &views, &base);
        let filter = Filter::new(&mut program, mesh, &order(mesh, 16), base.vertices, 3);

        let last = collapses.last().0;
        let sweep = sweep(collapses);
        let touched = sweep.windows(2).map(|pair| u64::from(pair[0].max(pair[1]).0)).sum();
        let moves = |stops: &[Lod]| stops.windows(2).map(|pair| vec![base.extraction(pair[0], pair[1])]).collect();
        // One entry and nearly all of them, so that every vertex is looked at and nearly every one is rewritten.
        let coarse = collapses.floor(Lod((u64::from(last) * 99 / 100) as u32));
        let jumps: Vec<Lod> = (0..9).map(|i| if i % 2 == 0 { Lod(0) } else { coarse }).collect();
        let whole = 8 * u64::from(coarse.0);

        let seen = eyes(mesh.bounds())
            .map(|eye| View { criterion: Criterion::Silhouette { eye, edge: Lod(0), face: coarse }, morph: false });
        let shown: Vec<Vec<Pass>> = seen.iter().map(|view| dependent.passes(view, &views)).collect();
        let morphed = seen.iter().map(|&view| dependent.passes(&View { morph: true, ..view }, &views)).collect();
        let filtered = shown.iter().map(|view| view.iter().cloned().chain(filter.passes()).collect()).collect();
        let all = 8 * mesh.vertex_count() as u64;
        let case = |name, runs, vertices| Case { name, runs, vertices };
        let cases = vec![
            case("construction", vec![base.construction()], mesh.vertex_count() as u64),
            case("continuous, linear sweep", moves(&sweep), touched),
            case("continuous, whole mesh", moves(&jumps), whole),
            case("live count", vec![vec![counting.pass()]; 8], all),
            case("view-dependent", shown, all),
            case("view-dependent, morphing", morphed, all),
            case("degenerate filter alone", vec![filter.passes(); 8], all),
            case("view-dependent, filtered", filtered, all),
        ];
        // The filter has triangles of its own: an engine keeps one copy.
        let dependent_words = program.bytes() / 4 - 3 * mesh.triangles().len() as u64;
        let memory = vec![("continuous", continuous), ("view-dependent", dependent_words)];
        Ok(Benchmark { program, memory, setup: base.construction(), cases })
    }
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
