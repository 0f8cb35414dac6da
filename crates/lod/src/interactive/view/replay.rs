//! Tests of view-dependent levels: every criterion from random viewpoints, with and without
//! morphing, as a [`Plan`] for a device and as a check on the CPU.
//!
//! The CPU code that does the same as the kernels is their *CPU version* ([`Views`]). It is
//! compared with the collapse sequence ([`ViewReference`]).

use super::{Criterion, Filter, ViewPasses, ViewQuery, Views, filtered};
use crate::interactive::{Interactive, replay};
use lodc_mesh::{Lod, Simplified, SplitMix64};
use lodc_model::Model;
use lodc_plan::{Expected, Plan, PlanError, Program, Step, Tolerance, VertexRecords};
use lodc_strip::order;
use lodc_verify::{Check, Reference, ViewReference};

/// Views of a round of [`sample`].
const VIEWS_PER_ROUND: usize = 10;
/// Triangles of a mesh up to which views are checked with morphing as well: a check of larger ones
/// takes seconds. Chosen by hand.
const MAX_TRIANGLES_MORPHED: usize = 200_000;
/// Entries of the vertex cache that triangles are ordered for.
const CACHE_ENTRIES: u32 = 16;
/// Triangles, over all rounds of views, that a plan for a device has at most, and its most rounds.
/// Chosen by hand.
const MAX_TRIANGLES_IN_ROUNDS: usize = 2_000_000;
const MAX_ROUNDS: usize = 8;

impl Interactive {
    /// Plans of everything that runs on a device: levels that are the same everywhere, at `lods`,
    /// and view-dependent levels over a sample of views, fewer on large meshes.
    ///
    /// # Errors
    /// If the mesh is too large or its lists too long.
    pub fn replays<'a>(
        &'a self,
        lods: &[Lod],
        reference: &'a Reference<'_>,
    ) -> Result<Vec<Plan<'a>>, PlanError> {
        let mesh = self.simplified().mesh();
        // Each round has ten views, each of which is resolved on the CPU as well.
        let triangles = mesh.triangles().len().max(1);
        let rounds = (MAX_TRIANGLES_IN_ROUNDS / triangles).clamp(1, MAX_ROUNDS) as u32;
        let views = sample(self.simplified(), rounds, 1);
        Ok(vec![
            self.continuous(lods.to_vec(), reference)?,
            self.views(views, order(mesh, CACHE_ENTRIES))?,
        ])
    }

    /// Compares a few views on the CPU with the collapse sequence: every criterion without
    /// morphing, and on small meshes with it, too.
    #[must_use]
    pub fn verify_views(&self) -> Check {
        let simplified = self.simplified().as_ref();
        let mesh = simplified.mesh();
        let views = Views::new(simplified, VertexRecords::positions(mesh));
        let reference = ViewReference::new(simplified);
        let rounds = if mesh.triangles().len() <= MAX_TRIANGLES_MORPHED { 2 } else { 1 };
        let mut queries = sample(simplified, rounds, 2);
        // The first round without morphing, the second, if there is one, with it.
        let numbered = queries.iter_mut().enumerate();
        numbered.for_each(|(i, query)| query.morph = i >= VIEWS_PER_ROUND);
        let stride = views.records.stride;
        let (model, name) = (self.name(), "view-dependent");
        let mut check = Check { model, name, lods: 0, full: 0, failure: None };
        for query in &queries {
            let shown = views.show(query);
            let remaining = filtered(mesh, mesh.triangles(), &shown.vertices, stride);
            check.lods += 1;
            check.full += 1;
            check.failure = shown.check(&reference, query, &remaining.indices, stride);
            if check.failure.is_some() {
                break;
            }
        }
        check
    }

    /// A plan of view-dependent levels, each compared in full: drawn records, compacted triangles
    /// and draw arguments with the CPU version; the CPU version's level with the collapse sequence,
    /// and that it has no cracks. `triangles` are those of the mesh, submesh by submesh, in the
    /// order in which they are drawn.
    ///
    /// # Errors
    /// If the mesh is too large, or one vertex has more collapses than kernels follow.
    pub fn views(
        &self,
        views: Vec<ViewQuery>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Plan<'_>, PlanError> {
        let simplified = self.simplified().as_ref();
        let mesh = simplified.mesh();
        replay::checked_depth(&replay::lists(simplified)?)?;
        let records = VertexRecords::whole(mesh)?;
        let stride = records.stride;
        let mut program = Program::default();
        let source = program.words("source", records.words.as_slice());
        let vertices = program.words("vertices", records.words.as_slice());
        let cpu = Views::new(simplified, records);
        let device = ViewPasses::new(&mut program, &cpu, source, vertices);
        let filter = Filter::new(&mut program, mesh, &triangles, vertices, stride);
        let reference = ViewReference::new(simplified);
        let locate = replay::locate(
            simplified,
            [vertices, source],
            Vec::new(),
            [filter.triangles, filter.draws],
            stride,
        );
        let step = move |view: ViewQuery| {
            let shown = cpu.show(&view);
            let remaining = filtered(mesh, &triangles, &shown.vertices, stride);
            let wrong = shown.check(&reference, &view, &remaining.indices, stride);
            // Morphing computes positions in floats; all else is copied.
            let tolerance = view.morph.then_some(Tolerance { stride, floats: 3 });
            let checks = vec![
                Expected { tolerance, ..Expected::new(vertices, shown.vertices) },
                Expected::new(filter.drawn_before, remaining.drawn_before),
                Expected::new(filter.indices, remaining.indices),
                Expected::new(filter.draws, remaining.draws),
            ];
            let passes = std::iter::once(device.pass(&view)).chain(filter.passes()).collect();
            Step {
                at: name(&view),
                counts: true,
                passes,
                checks,
                cpu_failure: wrong.map(|w| w.to_string()),
            }
        };
        let moves = views.into_iter().map(step);
        Ok(Plan::of_moves([self.name(), "view-dependent"], program, &[vertices], moves, locate))
    }
}

fn name(view: &ViewQuery) -> String {
    let morph = if view.morph { " with morphing" } else { "" };
    match view.criterion {
        Criterion::Silhouette { eye, .. } => format!("silhouette from {eye:?}{morph}"),
        Criterion::ScreenError { eye, slope } => {
            format!("screen error {slope} from {eye:?}{morph}")
        }
        Criterion::Sphere { centre, radius, .. } => {
            format!("sphere of {radius} at {centre:?}{morph}")
        }
        Criterion::Region { inside, outside, .. } => {
            format!("LOD {} in a box, {} outside{morph}", inside.0, outside.0)
        }
        Criterion::Frustum { eye, target, .. } => {
            format!("on a screen from {eye:?} towards {target:?}{morph}")
        }
    }
}

/// Views for a verification: `rounds` random ones by each criterion, every second one with
/// morphing. Some eyes and the corner of a box are exactly at a vertex, with the other sign of its
/// zeros: 0 and −0 are the same position.
#[must_use]
pub fn sample(simplified: &Simplified, rounds: u32, seed: u64) -> Vec<ViewQuery> {
    let (collapses, mesh) = (simplified.collapses(), simplified.mesh());
    let mut random = SplitMix64::new(seed);
    let mut unit = || random.unit();
    let (low, high) = mesh.bounds();
    let size = (0..3).map(|i| high[i] - low[i]).fold(1e-6, f32::max);
    let last = collapses.last().0;
    let mut views = vec![];
    for round in 0..rounds {
        let mut lod = || Lod((unit() * last as f32) as u32);
        let (a, b) = (lod(), lod());
        let (fine, coarse) = (a.min(b), a.max(b));
        let mut point = |spread: f32| -> [f32; 3] {
            std::array::from_fn(|i| f32::midpoint(low[i], high[i]) + (unit() - 0.5) * spread * size)
        };
        // A vertex, with the other sign of its zeros.
        let vertex = |share: f32| {
            let positions = mesh.positions();
            let at = positions.get((share * positions.len() as f32) as usize);
            at.map_or([0.0; 3], |p| p.map(|c| if c == 0.0 { -c } else { c }))
        };
        let (eye, centre, corner) = (point(6.0), point(1.0), point(1.5));
        let side = 0.6 * size;
        // 1, 3, 5 ... pixels of 1,000, with half an angle whose tangent is 0.5.
        let slope = Criterion::slope(1.0 + 2.0 * round as f32, 1000.0, 0.5);
        // Tangents of half the angles of a screen of 16 by 9, from narrow to wide.
        let tangents = [1.6, 0.9].map(|size| size * (0.1 + 0.6 * (round % 4) as f32));
        let at_corner = |low: [f32; 3]| {
            // Flat where the vertex has a zero, so that both sides of the box are that zero.
            let high = low.map(|c| if c == 0.0 { c } else { c + side });
            Criterion::Region { low, high, inside: fine, outside: coarse }
        };
        let criteria = [
            Criterion::everywhere(a),
            Criterion::Silhouette { eye, edge: fine, face: coarse, width: 1.0 - unit() },
            Criterion::ScreenError { eye, slope },
            Criterion::Sphere { centre, radius: 0.5 * side, inside: a, outside: b },
            Criterion::Region {
                low: corner,
                high: corner.map(|c| c + side),
                inside: b,
                outside: a,
            },
            Criterion::Silhouette { eye: vertex(unit()), edge: fine, face: coarse, width: 0.5 },
            Criterion::ScreenError { eye: vertex(unit()), slope },
            at_corner(vertex(unit())),
            Criterion::Frustum { eye, target: centre, tangents, inside: fine, outside: coarse },
            Criterion::Frustum { eye: centre, target: corner, tangents, inside: a, outside: b },
        ];
        let morph = |i: usize| (i + round as usize) % 2 == 1;
        views.extend(
            criteria
                .into_iter()
                .enumerate()
                .map(|(i, criterion)| ViewQuery { criterion, morph: morph(i) }),
        );
    }
    views
}
