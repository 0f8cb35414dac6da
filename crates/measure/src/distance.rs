//! Distances between two surfaces (as Cignoni et al. 1998, Metro, measure them).

use crate::spread::{over_area, over_triangles};
use crate::surface::Surface;
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{TriangleTree, morton_order};
use rayon::prelude::*;

/// Points that one thread looks up one after the other.
const RUN: usize = 256;

/// Density of samples on surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Points spread over the area of each surface.
    pub samples: usize,
    /// Most points, on lattices over the triangles of each, that are asked besides for the largest
    /// distance.
    pub lattice: usize,
    /// Makes the samples.
    pub seed: u64,
}

impl Sampling {
    /// 200,000 samples, lattices of 300,000 points.
    pub const DEFAULT: Self = Self { samples: 200_000, lattice: 300_000, seed: 1 };
}

/// Distances from one surface to another and back, in their unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// The largest distance found from any point of the first to the second surface, and the other
    /// way. Sampled, so never more than the true one.
    pub hausdorff: [f64; 2],
    /// Root mean square distance, over the area, from the first to the second, and the other way.
    pub rms: [f64; 2],
}

/// Measures both ways. Without triangles on one side, distances to it are infinite; from it, zero.
#[must_use]
pub fn distances(a: &Surface, b: &Surface, sampling: &Sampling) -> Distances {
    let ([to_b, from_b], [mean, mean_back]) = {
        let (to_b, back) = (one_way(a, &b.tree(), sampling), one_way(b, &a.tree(), sampling));
        ([to_b.0, back.0], [to_b.1, back.1])
    };
    Distances { hausdorff: [to_b, from_b], rms: [mean, mean_back] }
}

/// Largest and root mean square distance from one surface to another.
fn one_way(from: &Surface, to: &TriangleTree, sampling: &Sampling) -> (f64, f64) {
    let area = squares(&over_area(from, sampling.samples, sampling.seed), to);
    let lattice = squares(&over_triangles(from, sampling.lattice), to);
    let largest = area.iter().chain(&lattice).copied().fold(0.0, f64::max);
    let mean = if area.is_empty() { 0.0 } else { area.iter().sum::<f64>() / area.len() as f64 };
    (largest.sqrt(), mean.sqrt())
}

/// The squared distances of points, each searched for from the triangle of one that is near.
fn squares(points: &[DVec3], to: &TriangleTree) -> Vec<f64> {
    let order = morton_order(0..points.len() as u32, |i| [points[i as usize].as_vec3().into(); 3]);
    let along = |run: &[u32]| {
        let mut hint = NONE;
        let look = |&i: &u32| {
            let (squared, triangle) = to.distance_from(points[i as usize], hint);
            hint = triangle;
            squared
        };
        run.iter().map(look).collect::<Vec<f64>>()
    };
    let found: Vec<Vec<f64>> = order.par_chunks(RUN).map(along).collect();
    let mut squares = vec![0.0; points.len()];
    for (&i, squared) in order.iter().zip(found.into_iter().flatten()) {
        squares[i as usize] = squared;
    }
    squares
}

/// Returns the largest distance found from one surface to another, if it is more than `bound`.
/// Asks the points that [`distances`] asks, but each only whether it is that far off.
#[must_use]
pub fn farther_than(
    from: &Surface,
    to: &TriangleTree,
    bound: f64,
    sampling: &Sampling,
) -> Option<f64> {
    let area = over_area(from, sampling.samples, sampling.seed);
    let lattice = over_triangles(from, sampling.lattice);
    let points = area.par_iter().chain(&lattice);
    let off = points.filter(|&&p| !to.may_be_within(p, bound * bound));
    let largest = off.map(|&p| to.distance_squared(p)).max_by(f64::total_cmp)?.sqrt();
    (largest > bound).then_some(largest)
}
