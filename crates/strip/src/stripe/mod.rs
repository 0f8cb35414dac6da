//! Few long strips: the greedy heuristic of Stripe (Evans, Skiena and Varshney 1996), then
//! simulated annealing that also *tunnels* (Stewart 2001), region by region.

mod greedy;
mod regions;
mod search;

use crate::adjacency::{decode, neighbours};
use crate::cover::{Cover, submesh_of};
use crate::meter::{Meter, Report};
use crate::{Effort, StripSet};
use lodc_mesh::{Mesh, is_degenerate};

/// Makes few long strips that draw exactly the mesh.
///
/// Judge them by indices per triangle: 1.1 to 1.2 on scanned surfaces. For vertex caches they are
/// no better than any other order that follows the surface; [`crate::cache()`] makes strips for
/// those. Work on several regions runs on rayon's current thread pool.
#[must_use]
pub fn stripe(mesh: &Mesh, effort: Effort) -> StripSet {
    stripe_reporting(mesh, effort, &|_| {})
}

/// [`stripe`] with reports of progress.
pub(crate) fn stripe_reporting(mesh: &Mesh, effort: Effort, report: Report<'_>) -> StripSet {
    let triangles = mesh.triangles();
    let mut cover = Cover::new(neighbours(triangles, mesh.vertex_count()).into_iter());
    greedy::cover(&mut cover);
    let rounds = schedule(effort);
    regions::improve(&mut cover, rounds, &Meter::new(report, rounds.len()));
    let submesh = submesh_of(mesh);
    let mut indices = Vec::with_capacity(triangles.len() * 5 / 4);
    let mut strips = Vec::new();
    cover.paths(|path| {
        let (first, _) = decode(path[0]);
        if !is_degenerate(triangles[first as usize]) {
            let start = indices.len();
            cover.write(path, triangles, &mut indices);
            strips.push((submesh[first as usize], start..indices.len()));
        }
    });
    StripSet::new(mesh.submeshes().len(), &strips, &indices)
}

/// The rounds of the search, by effort.
fn schedule(effort: Effort) -> &'static [search::Round] {
    match effort {
        Effort::Fast => FAST,
        Effort::Default => DEFAULT,
        Effort::Thorough => THOROUGH,
    }
}

/// Chosen by indices per triangle on three scans (bunny, cow, igea). Two indices are what a strip
/// costs by itself, three with a restart index. Starting with three would freeze early, ending with
/// it costs nothing.
const FAST: &[search::Round] = &[search::Round {
    proposals: 1.5,
    start_temperature: 0.25,
    end_temperature: 0.15,
    strip_cost: 2,
}];
const DEFAULT: &[search::Round] = &[
    search::Round { proposals: 4.0, start_temperature: 0.6, end_temperature: 0.4, strip_cost: 2 },
    search::Round { proposals: 4.0, start_temperature: 0.4, end_temperature: 0.2, strip_cost: 2 },
    search::Round { proposals: 4.0, start_temperature: 0.35, end_temperature: 0.15, strip_cost: 3 },
];
const THOROUGH: &[search::Round] = &[
    search::Round {
        proposals: 78.0,
        start_temperature: 0.55,
        end_temperature: 0.45,
        strip_cost: 2,
    },
    search::Round {
        proposals: 78.0,
        start_temperature: 0.45,
        end_temperature: 0.38,
        strip_cost: 2,
    },
    search::Round {
        proposals: 78.0,
        start_temperature: 0.38,
        end_temperature: 0.32,
        strip_cost: 2,
    },
    search::Round {
        proposals: 78.0,
        start_temperature: 0.32,
        end_temperature: 0.27,
        strip_cost: 2,
    },
    search::Round {
        proposals: 78.0,
        start_temperature: 0.27,
        end_temperature: 0.22,
        strip_cost: 2,
    },
    search::Round {
        proposals: 78.0,
        start_temperature: 0.25,
        end_temperature: 0.15,
        strip_cost: 3,
    },
];
