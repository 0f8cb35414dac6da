//! Strips of bounded length for a vertex cache: a greedy pass (`greedy`) over parts of the surface
//! (`parts`), then simulated annealing on short stretches of the drawing order (`refine`,
//! `window`).

mod greedy;
mod parts;
mod paths;
mod refine;
mod window;

use crate::adjacency::neighbours;
use crate::cover::submesh_of;
use crate::meter::{Meter, Report};
use crate::{Effort, StripSet};
use greedy::Weights;
use lodc_mesh::Mesh;
use rayon::prelude::*;
use refine::{Drawing, Goal, refine};
use window::Schedule;

/// Options of cache-aware strips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CacheOptions {
    /// Number of vertices the cache holds (first in, first out). Values outside 4 to 64 are taken
    /// as the nearest of those.
    pub cache_size: u32,
    /// The time that the search may take.
    pub effort: Effort,
}

impl Default for CacheOptions {
    fn default() -> Self {
        Self { cache_size: 16, effort: Effort::Default }
    }
}

/// Makes short strips that draw exactly the mesh and ask a vertex cache for few vertices that it
/// does not hold.
#[must_use]
pub fn cache(mesh: &Mesh, options: &CacheOptions) -> StripSet {
    cache_reporting(mesh, options, &|_| {})
}

/// [`cache`] with reports of progress.
pub(crate) fn cache_reporting(mesh: &Mesh, options: &CacheOptions, report: Report<'_>) -> StripSet {
    let triangles = mesh.triangles();
    let size = options.cache_size.clamp(4, 64);
    let neighbours = neighbours(triangles, mesh.vertex_count());
    let weights = weights(options.effort);
    let parts = parts::divide(triangles, &neighbours, mesh.vertex_count());
    let paths = parts.par_iter().map(|part| greedy::paths(part, size, weights));
    let paths: Vec<Vec<Vec<u32>>> = paths.collect();
    let paths: Vec<Vec<u32>> = paths.into_iter().flatten().collect();
    let drawing = Drawing { paths: &paths, triangles, neighbours: &neighbours };
    let schedules = schedules(options.effort);
    let goal = Goal { cache_size: size, schedules };
    let refined = refine(&drawing, &goal, &Meter::new(report, 1));
    let submesh = submesh_of(mesh);
    let mut indices = Vec::with_capacity(triangles.len() * 3 / 2);
    let mut strips = Vec::with_capacity(refined.len());
    for strip in &refined {
        let start = indices.len();
        indices.extend(&strip.indices);
        strips.push((submesh[strip.first_triangle as usize], start..indices.len()));
    }
    StripSet::new(mesh.submeshes().len(), &strips, &indices)
}

/// Chosen by fetched vertices plus indices on three scans.
fn schedules(effort: Effort) -> &'static [Schedule] {
    match effort {
        Effort::Fast => &[],
        Effort::Default => &[Schedule {
            proposals: 2.5,
            stretch: 200,
            start_temperature: 0.3,
            end_temperature: 0.05,
        }],
        Effort::Thorough => &[Schedule {
            proposals: 80.0,
            stretch: 400,
            start_temperature: 0.4,
            end_temperature: 0.05,
        }],
    }
}

/// Weights found by a search over three scans; the thorough ones try more for longer strips.
fn weights(effort: Effort) -> Weights {
    let default = Weights {
        index: 0.12,
        evicted: 0.28,
        finished: 0.56,
        triangle: 0.87,
        max_length: 14,
        min_cached: 2,
        max_tried: 12,
    };
    match effort {
        Effort::Fast | Effort::Default => default,
        Effort::Thorough => {
            Weights { max_length: 20, min_cached: 1, max_tried: usize::MAX, ..default }
        }
    }
}
