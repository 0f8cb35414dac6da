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

/// Samples whose triangles are looked at more closely, those that are farthest.
const WORST_SAMPLES: usize = 256;

/// Boxes that may be opened for that, for each triangle and besides.
const LOOKED_AT: [u32; 2] = [500, 30_000];

/// A sample is as good as beyond a bound from this share of it on.
const NEARLY: f64 = 0.8;

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
    /// way. Sampled, then searched where samples are farthest: never more than the true one.
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
        let there = self.samples.farthest_and_mean(&other.tree(), |t| self.tree.corners_of(t));
        let back = Samples::new(other, &self.sampling);
        let back = back.farthest_and_mean(&self.tree, |t| other.corners(t as usize));
        Distances { hausdorff: [there.0, back.0], rms: [there.1, back.1] }
    }
}

impl Original {
    /// An upper bound of the largest distance between any point of either surface and the other,
    /// and the root mean square distance, the larger of both ways. The bound is no more than 2 %
    /// above the distance unless surfaces are very tangled, and infinite if one surface alone has
    /// no triangles.
    #[must_use]
    pub fn bound_and_rms(&self, other: &Surface) -> (f64, f64) {
        let own: Vec<_> =
            (0..self.tree.order().len() as u32).map(|t| self.tree.corners_of(t)).collect();
        let others: Vec<_> = (0..other.triangles.len()).map(|t| other.corners(t)).collect();
        let (low, high) = own
            .as_flattened()
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| {
                (low.min(p), high.max(p))
            });
        let search = Search::within((high - low).max(DVec3::ZERO).length());
        let tree = TriangleTree::new(&others);
        let there = || (search.farthest(&own, &tree).most, self.samples.area.mean_square(&tree));
        let back = || {
            let area = over_area(other, self.sampling.samples, self.sampling.seed);
            (search.farthest(&others, &*self.tree).most, Points::new(area).mean_square(&self.tree))
        };
        let (there, back) = rayon::join(there, back);
        let bound = there.0.max(back.0);
        // Rounding errors of coordinates are no distances.
        let bound = if bound <= 2.0 * search.floor { 0.0 } else { bound };
        (bound, there.1.max(back.1).sqrt())
    }
}

/// Points of a surface.
#[derive(Clone, Debug)]
struct Samples {
    area: Points,
    lattice: Points,
}

/// Points with the triangles that they are on, and an order in which neighbours are near each
/// other.
#[derive(Clone, Debug)]
struct Points {
    places: Vec<DVec3>,
    triangles: Vec<u32>,
    order: Vec<u32>,
}

impl Points {
    fn new(points: Vec<(DVec3, u32)>) -> Self {
        let (places, triangles): (Vec<DVec3>, Vec<u32>) = points.into_iter().unzip();
        let place = |i: u32| [places[i as usize].as_vec3().into(); 3];
        let order = morton_order(0..places.len() as u32, place);
        Self { places, triangles, order }
    }

    /// The mean squared distance to a surface; 0 without points.
    fn mean_square(&self, to: &TriangleTree) -> f64 {
        mean(&squares(self, to))
    }
}

impl Samples {
    fn new(surface: &Surface, sampling: &Sampling) -> Self {
        Self {
            area: Points::new(over_area(surface, sampling.samples, sampling.seed)),
            lattice: Points::new(over_triangles(surface, sampling.lattice)),
        }
    }

    /// The largest and the root mean square distance to another surface. The triangles of the
    /// samples that are farthest, with `corners`, are looked at more closely.
    fn farthest_and_mean(
        &self,
        to: &TriangleTree,
        corners: impl Fn(u32) -> [DVec3; 3],
    ) -> (f64, f64) {
        let [area, lattice] = [&self.area, &self.lattice].map(|points| squares(points, to));
        let mean = mean(&area);
        let with_triangles = |squares: Vec<f64>, points: &Points| {
            squares.into_iter().zip(points.triangles.iter().copied()).collect::<Vec<_>>()
        };
        let mut all = with_triangles(area, &self.area);
        all.extend(with_triangles(lattice, &self.lattice));
        (beyond_samples(all, to, corners), mean.sqrt())
    }
}

/// The mean squared distance from points of one surface, each in a slice of equal area, to another;
/// 0 without area.
pub(crate) fn mean_square(from: &Surface, to: &TriangleTree, samples: usize, seed: u64) -> f64 {
    Points::new(over_area(from, samples, seed)).mean_square(to)
}

fn mean(squares: &[f64]) -> f64 {
    if squares.is_empty() { 0.0 } else { squares.iter().sum::<f64>() / squares.len() as f64 }
}

/// The largest distance found from the triangles of samples, given with their squared distances.
fn beyond_samples(
    mut samples: Vec<(f64, u32)>,
    to: &TriangleTree,
    corners: impl Fn(u32) -> [DVec3; 3],
) -> f64 {
    let worst = samples.len().min(WORST_SAMPLES);
    if worst < samples.len() {
        samples.select_nth_unstable_by(worst, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    }
    let largest = samples.iter().map(|s| s.0).fold(0.0, f64::max).sqrt();
    if largest == 0.0 || largest.is_infinite() {
        return largest;
    }
    let mut triangles: Vec<u32> = samples[..worst].iter().map(|s| s.1).collect();
    triangles.sort_unstable();
    triangles.dedup();
    let from: Vec<[DVec3; 3]> = triangles.into_iter().map(corners).collect();
    let search = Search { tolerance: 0.01, boxes: LOOKED_AT, ..Search::within(largest) };
    largest.max(search.farthest(&from, to).least)
}

/// The squared distances of points, each searched for from the triangle of the one before it in an
/// order.
fn squares(points: &Points, to: &TriangleTree) -> Vec<f64> {
    let Points { places, order, .. } = points;
    let along = |run: &[u32]| {
        let mut hint = NONE;
        let look = |&i: &u32| {
            let (squared, triangle) = to.distance_from(places[i as usize], hint);
            hint = triangle;
            squared
        };
        run.iter().map(look).collect::<Vec<f64>>()
    };
    let found: Vec<Vec<f64>> = order.par_chunks(RUN).map(along).collect();
    let mut squares = vec![0.0; places.len()];
    for (&i, squared) in order.iter().zip(found.into_iter().flatten()) {
        squares[i as usize] = squared;
    }
    squares
}

/// Returns the largest distance found from one surface to another, if it is more than `bound`.
/// Asks the points that [`distances`] asks, each first whether it is about that far off, and looks
/// more closely at the triangles of those that are.
#[must_use]
pub fn farther_than(
    from: &Surface,
    to: &TriangleTree,
    bound: f64,
    sampling: &Sampling,
) -> Option<f64> {
    let Samples { area, lattice } = Samples::new(from, sampling);
    let near = NEARLY * bound;
    let far_ones = |points: &Points| {
        let along = |run: &[u32]| {
            let mut hint = NONE;
            let is_far =
                |&&i: &&u32| !to.may_be_within(points.places[i as usize], near * near, &mut hint);
            let far: Vec<u32> = run.iter().filter(is_far).copied().collect();
            let squared = |i: u32| to.distance_squared(points.places[i as usize]);
            far.into_iter().map(|i| (squared(i), points.triangles[i as usize])).collect::<Vec<_>>()
        };
        points.order.par_chunks(RUN).flat_map_iter(along).collect::<Vec<_>>()
    };
    let mut far = far_ones(&area);
    far.extend(far_ones(&lattice));
    if far.is_empty() {
        return None;
    }
    let largest = beyond_samples(far, to, |t| from.corners(t as usize));
    (largest > bound).then_some(largest)
}
