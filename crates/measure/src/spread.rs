//! Sample points on a surface: one in each slice of equal area, or a lattice on each triangle. They
//! depend on the surface and the seed, not on the number of threads.

use crate::surface::Surface;
use glam::DVec3;
use lodc_mesh::SplitMix64;
use rayon::prelude::*;

/// Largest number of intervals into which a lattice cuts a triangle's edge. Chosen by hand.
const MAX_INTERVALS: usize = 7;

/// `count` points with their triangles, one in each of `count` slices of equal area.
pub(crate) fn over_area(surface: &Surface, count: usize, seed: u64) -> Vec<(DVec3, u32)> {
    let area = |t| {
        let [a, b, c] = surface.corners(t);
        (b - a).cross(c - a).length()
    };
    let areas: Vec<f64> = (0..surface.triangles.len()).map(area).collect();
    over_weights(surface, &areas, count, seed)
}

/// As [`over_area`], in slices of equal weight; the weight of a triangle is spread evenly over it.
pub(crate) fn over_weights(
    surface: &Surface,
    weights: &[f64],
    count: usize,
    seed: u64,
) -> Vec<(DVec3, u32)> {
    let mut sum = 0.0;
    let add = |weight: &f64| {
        sum += weight;
        sum
    };
    let sums: Vec<f64> = weights.iter().map(add).collect();
    if sum <= 0.0 || !sum.is_finite() {
        return Vec::new();
    }
    (0..count)
        .into_par_iter()
        .map(|i| {
            let unit = |k: u64| unit(seed, 3 * i as u64 + k);
            let slice = (i as f64 + unit(0)) / count as f64 * sum;
            let triangle = sums.partition_point(|&s| s <= slice).min(sums.len() - 1);
            let (r, t) = (unit(1).sqrt(), unit(2));
            let [a, b, c] = surface.corners(triangle);
            (a * (1.0 - r) + b * (r * (1.0 - t)) + c * (r * t), triangle as u32)
        })
        .collect()
}

/// The points, with their triangles, of a regular lattice on every triangle, corners and edges
/// included, as fine as `max_points` points in all allow: it finds what area samples miss on
/// slivers. With too many triangles for that, the corners of some.
pub(crate) fn over_triangles(surface: &Surface, max_points: usize) -> Vec<(DVec3, u32)> {
    let triangles = surface.triangles.len();
    let points = |k: usize| (k + 1) * (k + 2) / 2;
    let k = (1..=MAX_INTERVALS).rev().find(|&k| points(k) * triangles <= max_points).unwrap_or(1);
    let stride = (points(k) * triangles).div_ceil(max_points.max(1)).max(1);
    let lattice = |t: usize| {
        let [a, b, c] = surface.corners(t);
        (0..=k).flat_map(move |i| {
            (0..=k - i)
                .map(move |j| (a * i as f64 + b * j as f64 + c * (k - i - j) as f64) / k as f64)
                .map(move |point| (point, t as u32))
        })
    };
    (0..triangles).step_by(stride).flat_map(lattice).collect()
}

/// The `i`-th number of a sequence in [0, 1).
fn unit(seed: u64, i: u64) -> f64 {
    (SplitMix64::at(seed, i) >> 11) as f64 / (1u64 << 53) as f64
}
