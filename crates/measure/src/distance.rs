//! Distances between two surfaces (as Cignoni et al. 1998, Metro, measure them).

use crate::spread::{over_area, over_triangles};
use crate::surface::Surface;
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{Search, TriangleTree, morton_order};
use rayon::prelude::*;
use std::sync::Arc;

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
    Original::new(a, sampling).distances(b)
}

/// A surface, ready for others to be measured from it: its samples and its tree are made once.
#[derive(Clone, Debug)]
pub struct Original {
    samples: Samples,
    tree: Arc<TriangleTree>,
    sampling: Sampling,
}

impl Original {
    /// Prepares a surface.
    #[must_use]
    pub fn new(surface: &Surface, sampling: &Sampling) -> Self {
        Self::with_tree(surface, Arc::new(surface.tree()), sampling)
    }

    /// The same where the [tree](Surface::tree) of the surface is known.
    #[must_use]
    pub fn with_tree(surface: &Surface, tree: Arc<TriangleTree>, sampling: &Sampling) -> Self {
        Self { samples: Samples::new(surface, sampling), tree, sampling: *sampling }
    }

    /// Measures both ways, as [`distances`] does.
    #[must_use]
    pub fn distances(&self, other: &Surface) -> Distances {
        let there = self.samples.farthest_and_mean(&other.tree());
        let back = Samples::new(other, &self.sampling).farthest_and_mean(&self.tree);
        Distances { hausdorff: [there.0, back.0], rms: [there.1, back.1] }
    }
}

impl Original {
    /// An upper bound of the largest distance between any point of either surface and the other:
    /// no more than 2 % above it unless surfaces are very tangled. Samples only tell that it is no
    /// less than theirs. Infinite if one surface alone has no triangles.
    #[must_use]
    pub fn bound(&self, other: &Surface) -> f64 {
        let own: Vec<_> =
            (0..self.tree.order().len() as u32).map(|t| self.tree.corners_of(t)).collect();
        let others: Vec<_> = (0..other.triangles.len()).map(|t| other.corners(t)).collect();
        if own.is_empty() != others.is_empty() {
            return f64::INFINITY;
        }
        let (low, high) = own
            .as_flattened()
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| {
                (low.min(p), high.max(p))
            });
        let search = Search::within((high - low).max(DVec3::ZERO).length());
        let there = || search.farthest(&own, &TriangleTree::new(&others)).most;
        let back = || search.farthest(&others, &self.tree).most;
        let (there, back) = rayon::join(there, back);
        let bound = there.max(back);
        // Rounding errors of coordinates are no distances.
        if bound <= 2.0 * search.floor { 0.0 } else { bound }
    }
}

/// Points of a surface, each kind with an order in which neighbours are near each other.
#[derive(Clone, Debug)]
struct Samples {
    area: (Vec<DVec3>, Vec<u32>),
    lattice: (Vec<DVec3>, Vec<u32>),
}

impl Samples {
    fn new(surface: &Surface, sampling: &Sampling) -> Self {
        let ordered = |points: Vec<DVec3>| {
            let place = |i: u32| [points[i as usize].as_vec3().into(); 3];
            let order = morton_order(0..points.len() as u32, place);
            (points, order)
        };
        Self {
            area: ordered(over_area(surface, sampling.samples, sampling.seed)),
            lattice: ordered(over_triangles(surface, sampling.lattice)),
        }
    }

    /// The largest and the root mean square distance to another surface.
    fn farthest_and_mean(&self, to: &TriangleTree) -> (f64, f64) {
        let [area, lattice] = [&self.area, &self.lattice].map(|(p, order)| squares(p, order, to));
        let largest = area.iter().chain(&lattice).copied().fold(0.0, f64::max);
        let mean = if area.is_empty() { 0.0 } else { area.iter().sum::<f64>() / area.len() as f64 };
        (largest.sqrt(), mean.sqrt())
    }
}

/// The squared distances of points, each searched for from the triangle of the one before it in an
/// order.
fn squares(points: &[DVec3], order: &[u32], to: &TriangleTree) -> Vec<f64> {
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
    let Samples { area, lattice } = Samples::new(from, sampling);
    let farthest = |(points, order): &(Vec<DVec3>, Vec<u32>)| {
        let along = |run: &[u32]| {
            let mut hint = NONE;
            let points = run.iter().map(|&i| points[i as usize]);
            let off = points.filter(|&p| !to.may_be_within(p, bound * bound, &mut hint));
            off.map(|p| to.distance_squared(p)).max_by(f64::total_cmp)
        };
        order.par_chunks(RUN).filter_map(along).max_by(f64::total_cmp)
    };
    let farthest = farthest(&area).into_iter().chain(farthest(&lattice));
    let largest = farthest.max_by(f64::total_cmp)?.sqrt();
    (largest > bound).then_some(largest)
}
