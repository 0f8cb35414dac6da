//! Strips of bounded length for a vertex cache: a greedy pass, then a local search on short stretches of the drawing order.

mod greedy;
mod paths;
mod refine;
mod window;

use crate::adjacency::{decode, neighbours};
use crate::cover::{Cover, submesh_of};
use crate::{Effort, StripSet};
use greedy::Weights;
use window::Search;
use lodc_mesh::Mesh;

/// What cache-aware strips are made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CacheOptions {
    /// How many vertices the cache holds (first in, first out). Values outside 4 to 64 are taken as the nearest of those.
    pub cache_size: u32,
    /// How many fetched vertices one index is worth: more makes longer strips, less makes fewer misses.
    pub index_price: f32,
    /// How long to search.
    pub effort: Effort,
}

impl Default for CacheOptions {
    fn default() -> Self {
        Self { cache_size: 16, index_price: 0.3, effort: Effort::Default }
    }
}

/// Makes short strips that draw exactly the mesh and ask a vertex cache for few vertices that it does not hold.
#[must_use]
pub fn cache(mesh: &Mesh, options: &CacheOptions) -> StripSet {
    let triangles = mesh.triangles();
    let size = options.cache_size.clamp(4, 64);
    let mut cover = Cover::new(&neighbours(triangles, mesh.vertex_count()));
    let mut weights = weights(options.effort);
    if let Ok(s) = std::env::var("W") {
        let f: Vec<f32> = s.split(',').map(|x| x.parse().unwrap()).collect();
        weights = Weights {
            index: f[0],
            evicted: f[1],
            finished: f[2],
            triangle: f[3],
            longest: f[4] as usize,
            cached: f[5] as usize,
        };
    }
    let order = greedy::strips(triangles, mesh.vertex_count(), &mut cover, size, weights);
    let paths: Vec<Vec<u32>> = order
        .iter()
        .map(|&first| {
            let mut path = Vec::new();
            cover.path(decode(first).0, &mut path);
            path
        })
        .collect();
    let mut searches = searches(options.effort).to_vec();
    let mut price = options.index_price;
    if let Ok(s) = std::env::var("B") {
        searches = s.split(';').map(|r| { let f: Vec<f64> = r.split(',').map(|x| x.parse().unwrap()).collect(); price = f[4] as f32; Search { proposals: f[0], warm: f[1], cold: f[2], window: f[3] as usize } }).collect();
    }
    let refined = refine::refine(&paths, triangles, &cover, size, price, &searches);
    let submesh = submesh_of(mesh);
    let mut indices = Vec::with_capacity(triangles.len() * 3 / 2);
    let mut strips = Vec::with_capacity(order.len());
    for (first, strip) in &refined {
        let start = indices.len();
        indices.extend(strip);
        strips.push((submesh[*first as usize], start..indices.len()));
    }
    StripSet::new(mesh.submeshes().len(), &strips, &indices)
}

fn searches(effort: Effort) -> &'static [Search] {
    match effort {
        Effort::Fast => &[],
        Effort::Default => &[Search { proposals: 3.0, window: 300, warm: 0.3, cold: 0.1 }],
        Effort::Thorough => &[Search { proposals: 40.0, window: 300, warm: 0.5, cold: 0.1 }],
    }
}

fn weights(effort: Effort) -> Weights {
    let all = Weights { index: 0.12, evicted: 0.28, finished: 0.56, triangle: 0.87, longest: 20, cached: 1 };
    match effort {
        Effort::Fast => Weights { cached: 2, longest: 16, ..all },
        _ => all,
    }
}
