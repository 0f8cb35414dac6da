//! Distances between two surfaces by sampled points: root mean square and largest, both ways (as
//! Cignoni et al. 1998, Metro). The largest is then searched for around the samples that are
//! farthest.

use crate::spread::{over_area, over_triangles};
use crate::surface::Surface;
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{FarthestSearch, TriangleTree, morton_order};
use rayon::prelude::*;

/// Points of one parallel task. Chosen by hand; results do not depend on it.
const TASK_POINTS: usize = 256;

/// Number of the farthest samples whose triangles are searched for points that are farther still.
/// Chosen by hand.
const WORST_SAMPLES: usize = 256;

/// Boxes of the tree that the search may open for each of these triangles, and further ones for all
/// together. Chosen by hand.
const BOX_BUDGET: [u32; 2] = [500, 30_000];

/// Density of samples on surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Points spread over the area of each surface.
    pub samples: usize,
    /// The most points, on lattices over the triangles of each surface, that are sampled besides
    /// for the largest distance.
    pub lattice: usize,
    /// The seed of the samples.
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

/// A surface from which others are measured: its samples and its tree are made once.
#[derive(Clone, Debug)]
pub struct Original {
    samples: Samples,
    tree: TriangleTree,
    sampling: Sampling,
}

impl Original {
    /// Prepares a surface.
    #[must_use]
    pub fn new(surface: &Surface, sampling: &Sampling) -> Self {
        let samples = Samples::new(surface, sampling);
        Self { samples, tree: surface.tree(), sampling: *sampling }
    }

    /// Measures both ways, as [`distances`] does.
    #[must_use]
    pub fn distances(&self, other: &Surface) -> Distances {
        let (largest_there, rms_there) =
            self.samples.largest_and_rms(&other.tree(), |t| self.tree.corners_of(t));
        let (largest_back, rms_back) = Samples::new(other, &self.sampling)
            .largest_and_rms(&self.tree, |t| other.corners(t as usize));
        Distances { hausdorff: [largest_there, largest_back], rms: [rms_there, rms_back] }
    }
}

/// Points of a surface.
#[derive(Clone, Debug)]
struct Samples {
    /// One in each slice of equal area.
    area: Points,
    /// Lattices over the triangles.
    lattice: Points,
}

/// Points with the triangles that they are on, and an order in which neighbours are near each
/// other.
#[derive(Clone, Debug)]
struct Points {
    positions: Vec<DVec3>,
    triangles: Vec<u32>,
    order: Vec<u32>,
}

impl Points {
    fn new(points: Vec<(DVec3, u32)>) -> Self {
        let (positions, triangles): (Vec<DVec3>, Vec<u32>) = points.into_iter().unzip();
        let position = |i: u32| [positions[i as usize].as_vec3().into(); 3];
        let order = morton_order(0..positions.len() as u32, position);
        Self { positions, triangles, order }
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
    /// farthest samples, whose corners `corners` gives, are searched for points that are farther
    /// still.
    fn largest_and_rms(
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
        (search_worst(all, to, corners), mean.sqrt())
    }
}

fn mean(squares: &[f64]) -> f64 {
    if squares.is_empty() { 0.0 } else { squares.iter().sum::<f64>() / squares.len() as f64 }
}

/// The largest distance found from the triangles of samples, given with their squared distances.
fn search_worst(
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
    let search =
        FarthestSearch { tolerance: 0.01, boxes: BOX_BUDGET, ..FarthestSearch::for_size(largest) };
    largest.max(search.farthest(&from, to).lower)
}

/// The squared distances of points, each searched for from the triangle of the one before it in an
/// order.
fn squares(points: &Points, to: &TriangleTree) -> Vec<f64> {
    let Points { positions, order, .. } = points;
    let measure_run = |run: &[u32]| {
        let mut hint = NONE;
        let measure = |&i: &u32| {
            let hit = to.nearest_triangle(positions[i as usize], hint);
            hint = hit.triangle;
            hit.squared
        };
        run.iter().map(measure).collect::<Vec<f64>>()
    };
    let measured: Vec<Vec<f64>> = order.par_chunks(TASK_POINTS).map(measure_run).collect();
    let mut squares = vec![0.0; positions.len()];
    for (&i, squared) in order.iter().zip(measured.into_iter().flatten()) {
        squares[i as usize] = squared;
    }
    squares
}
