//! Strips of bounded length for a vertex cache: a greedy pass, then a local search on short stretches of the drawing order.

mod greedy;

use crate::adjacency::{decode, neighbours};
use crate::cover::{Cover, submesh_of};
use crate::{Effort, StripSet};
use greedy::Weights;
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
    let submesh = submesh_of(mesh);
    let mut indices = Vec::with_capacity(triangles.len() * 3 / 2);
    let mut strips = Vec::with_capacity(order.len());
    let mut path = Vec::new();
    for &first in &order {
        let start = indices.len();
        let (t, _) = decode(first);
        cover.path(t, &mut path);
        cover.write_forward(&path, triangles, &mut indices);
        strips.push((submesh[t as usize], start..indices.len()));
    }
    StripSet::new(mesh.submeshes().len(), &strips, &indices)
}

fn weights(effort: Effort) -> Weights {
    let all = Weights { index: 0.12, evicted: 0.28, finished: 0.56, triangle: 0.87, longest: 20, cached: 1 };
    match effort {
        Effort::Fast => Weights { cached: 2, longest: 16, ..all },
        _ => all,
    }
}
