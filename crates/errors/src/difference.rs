//! Triangles that one of two surfaces has and the other has not: about how far each is, and the
//! mean squared distance over all.

use crate::rough::RoughSquare;
use glam::DVec3;
use lodc_mesh::{NONE, SplitMix64};
use lodc_nearest::{Query, Surface, centroid, point_at};
use rayon::prelude::*;

/// Triangles, or samples, that one thread looks at one after the other. Results depend on this.
/// Chosen by hand.
const PER_TASK: usize = 128;

/// Shares of the samples that go to triangles by area times estimated squared distance, and by
/// area; the others are the same for each triangle. Where the estimates are right, the first have
/// no variance; the others are for where they are not. Chosen by hand.
const BY_DISTANCE: f64 = 0.5;
const BY_AREA: f64 = 0.35;

/// Boxes that the search for the triangle nearest to a centroid may open, which only tells where
/// samples go and searches begin; and to a sample, whose distance counts. Chosen by hand: few
/// searches open hundreds.
const BOXES_PER_ESTIMATE: u32 = 256;
const BOXES_PER_SAMPLE: u32 = 16_384;

/// Triangles that are chosen of very many. Chosen by hand.
const CHOSEN: usize = 4_096;
/// Classes of squared distances: the exponent of an `f32` and five bits of its mantissa.
const DISTANCE_CLASSES: usize = 1 << 13;

/// About how far a triangle is from the other surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    /// The squared distance of its centroid, or about that of its samples.
    squared: f32,
    /// A triangle of the other surface near the centroid.
    pub(crate) near: u32,
}

/// Distances of samples from the other surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sampled {
    /// The mean squared distance over the whole surface.
    pub(crate) mean_square: f64,
    /// The largest distance of a sample whose search was finished.
    pub(crate) max_distance: f64,
    /// Boxes that were opened.
    pub(crate) boxes: u64,
}

/// The triangles of a surface that another one does not have.
pub(crate) struct Difference<F> {
    /// The area of each, and of all triangles of the surface.
    areas: Vec<f32>,
    surface_area: f64,
    /// The corners of each, and a triangle of the other surface that is probably near, or [`NONE`].
    triangle: F,
}

impl<F: Fn(usize) -> ([DVec3; 3], u32) + Sync> Difference<F> {
    pub(crate) fn new(areas: Vec<f32>, surface_area: f64, triangle: F) -> Self {
        Self { areas, surface_area, triangle }
    }

    pub(crate) fn len(&self) -> usize {
        self.areas.len()
    }

    pub(crate) fn corners(&self, i: usize) -> [DVec3; 3] {
        (self.triangle)(i).0
    }

    /// Estimates of triangles that are known to be about as far as `rough` returns.
    pub(crate) fn known(&self, rough: impl Fn(usize) -> RoughSquare) -> Vec<Estimate> {
        let known = |i| Estimate { squared: rough(i).get(), near: (self.triangle)(i).1 };
        (0..self.len()).map(known).collect()
    }

    /// Finds the triangle of the other surface nearest to the centroid of each.
    pub(crate) fn estimate(&self, to: &(impl Surface + Sync)) -> Vec<Estimate> {
        let task = |start: usize| {
            let mut last = NONE;
            let estimate = move |i: usize| {
                let (corners, hint) = (self.triangle)(i);
                let hint = if hint == NONE { last } else { hint };
                let point = centroid(corners);
                let max_boxes = BOXES_PER_ESTIMATE;
                let hit = to.near(Query { point, hint, enough: 0.0, max_boxes }).0;
                last = hit.triangle;
                Estimate { squared: hit.squared as f32, near: hit.triangle }
            };
            (start..(start + PER_TASK).min(self.len())).map(estimate)
        };
        let starts: Vec<usize> = (0..self.len()).step_by(PER_TASK).collect();
        starts.into_par_iter().flat_map_iter(task).collect()
    }

    /// Chooses some of very many triangles: half of them the farthest by their estimates, the
    /// others spread evenly over area and numbers. Returns their indices in order; `None` for all.
    pub(crate) fn choose(&self, estimates: &[Estimate]) -> Option<Vec<u32>> {
        if self.len() <= CHOSEN {
            return None;
        }
        // The farthest classes that have at most half of those wanted; a class spans 1.5 % of
        // distance.
        let class = |estimate: &Estimate| (estimate.squared.to_bits() >> 18) as usize;
        let mut counts = vec![0usize; DISTANCE_CLASSES];
        estimates.iter().for_each(|estimate| counts[class(estimate)] += 1);
        let mut far = 0;
        let first_far = (1..DISTANCE_CLASSES)
            .rev()
            .take_while(|&e| {
                far += counts[e];
                far <= CHOSEN / 2
            })
            .last()
            .unwrap_or(DISTANCE_CLASSES);
        // The others by slices of area and of numbers.
        let total: f64 = self.areas.iter().copied().map(f64::from).sum();
        let [by_area, by_number] =
            [total.max(f64::MIN_POSITIVE), self.len() as f64].map(|all| 0.25 * CHOSEN as f64 / all);
        let mut sum = 0.0f64;
        let mut chosen = Vec::with_capacity(CHOSEN);
        for ((&area, estimate), i) in self.areas.iter().zip(estimates).zip(0..) {
            let before = sum;
            sum += f64::from(area) * by_area + by_number;
            if class(estimate) >= first_far || before.floor() < sum.floor() {
                chosen.push(i);
            }
        }
        Some(chosen)
    }

    /// Samples the distance to the other surface at `samples` points: systematic sampling by a mix
    /// of area times estimated distance, of area, and of numbers.
    pub(crate) fn sample(
        &self,
        estimates: &[Estimate],
        to: &(impl Surface + Sync),
        samples: usize,
    ) -> Sampled {
        let moment = |(&area, estimate): (&f32, &Estimate)| {
            f64::from(area) * f64::from(estimate.squared.min(f32::MAX))
        };
        let total_area: f64 = self.areas.iter().copied().map(f64::from).sum();
        let total_moment: f64 = self.areas.iter().zip(estimates).map(moment).sum();
        if total_area <= 0.0 {
            return Sampled::default();
        }
        let all = samples as f64;
        let by_distance = if total_moment > 0.0 { all * BY_DISTANCE / total_moment } else { 0.0 };
        let by_area = all * BY_AREA / total_area;
        let by_number = all * (1.0 - BY_DISTANCE - BY_AREA) / self.len() as f64;
        // The expected number of samples of each triangle, added up: fewer in all without moments.
        let mut sum = 0.0;
        let add = |pair: (&f32, &Estimate)| {
            sum += moment(pair) * by_distance + f64::from(*pair.0) * by_area + by_number;
            sum
        };
        let ends: Vec<f64> = self.areas.iter().zip(estimates).map(add).collect();
        let task = |first: usize| {
            let mut random = SplitMix64::new(first as u64);
            let mut i = ends.partition_point(|&end| end <= first as f64);
            let (mut integral, mut max_squared, mut last) = (0.0, 0.0f64, NONE);
            let mut boxes = 0;
            for sample in first..first + PER_TASK {
                // One in each slice of the same weight.
                let at = sample as f64 + f64::from(random.unit());
                while i < ends.len() && ends[i] <= at {
                    i += 1;
                }
                let Some(&end) = ends.get(i) else { break };
                let count = end - if i > 0 { ends[i - 1] } else { 0.0 };
                // Where a triangle has many samples, they are spread along one direction.
                let along = (1.0 - (end - at) / count).clamp(0.0, 1.0);
                let u = 1.0 - (1.0 - along).sqrt();
                let v = (1.0 - u) * f64::from(random.unit());
                let corners = self.corners(i);
                let point = point_at(corners, [u, v, 1.0 - u - v]);
                let hint = if last == NONE { estimates[i].near } else { last };
                let hint = if count > 1.0 { hint } else { estimates[i].near };
                let query = Query { point, hint, enough: 0.0, max_boxes: BOXES_PER_SAMPLE };
                let (hit, opened_boxes) = to.near(query);
                boxes += u64::from(opened_boxes);
                last = hit.triangle;
                integral += hit.squared * f64::from(self.areas[i]) / count;
                if opened_boxes < BOXES_PER_SAMPLE {
                    max_squared = max_squared.max(hit.squared);
                }
            }
            (integral, max_squared, boxes)
        };
        let starts: Vec<usize> = (0..sum.ceil() as usize).step_by(PER_TASK).collect();
        let tasks: Vec<(f64, f64, u64)> = starts.into_par_iter().map(task).collect();
        let (integral, max_squared, boxes) =
            tasks.into_iter().fold((0.0, 0.0f64, 0), |all, task| {
                (all.0 + task.0, all.1.max(task.1), all.2 + task.2)
            });
        let mean_square = integral / self.surface_area.max(f64::MIN_POSITIVE);
        Sampled { mean_square, max_distance: max_squared.sqrt(), boxes }
    }
}
