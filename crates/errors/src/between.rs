//! The distance between two surfaces that need not have a point in common: of levels that are not
//! of the collapse sequence, since their vertices were moved, rounded or chosen otherwise.

use crate::check::samples;
use crate::difference::{Difference, Sampled};
use crate::input::to_dvec3;
use crate::settings::Limits;
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{FarthestSearch, MovingSurface, MovingTree, Triangles, area, morton_order};

/// A triangle surface, ready to be measured from others. Triangles that are a line or a point by
/// their corners are no part of it.
#[derive(Clone, Debug)]
pub struct Measurable {
    /// The corners of each triangle; neighbours in space are near each other.
    corners: Vec<[[f32; 3]; 3]>,
    areas: Vec<f32>,
    area: f64,
    tree: MovingTree,
    /// The diagonal of the bounding box.
    diagonal: f64,
}

/// How far two surfaces are apart, in their unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distances {
    /// A point of one of both surfaces is at least this far from the other, or this distance was
    /// known before.
    pub lower: f64,
    /// No point is farther: an upper bound of the Hausdorff distance, about 2 % above it. Infinite
    /// if one surface alone has no triangles.
    pub upper: f64,
    /// The root mean square distance over the area, the larger of both ways, from samples.
    pub rms: f64,
}

impl Distances {
    /// The larger of each.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            lower: self.lower.max(other.lower),
            upper: self.upper.max(other.upper),
            rms: self.rms.max(other.rms),
        }
    }
}

impl Measurable {
    /// Prepares a surface from the finite positions of its corners.
    #[must_use]
    pub fn new(triangles: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Self {
        let has_area = |[a, b, c]: &[[f32; 3]; 3]| a != b && b != c && c != a;
        let all: Vec<[[f32; 3]; 3]> = triangles.into_iter().filter(has_area).collect();
        let order = morton_order(0..all.len() as u32, |t| all[t as usize]);
        let corners: Vec<[[f32; 3]; 3]> = order.iter().map(|&t| all[t as usize]).collect();
        let areas: Vec<f32> = corners.iter().map(|&t| area(t.map(to_dvec3)) as f32).collect();
        let [low, high] = corners
            .as_flattened()
            .iter()
            .map(|&p| to_dvec3(p))
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| {
                [low.min(p), high.max(p)]
            });
        Self {
            area: areas.iter().copied().map(f64::from).sum(),
            tree: MovingTree::of_all(corners.len() as u32, |t| corners[t as usize]),
            diagonal: (high - low).max(DVec3::ZERO).length(),
            corners,
            areas,
        }
    }

    /// Measures how far another surface is from this one.
    #[must_use]
    pub fn distances(&self, other: &Self) -> Distances {
        self.measure(0.0, other, Limits::DEFAULT.samples)
    }

    /// As [`Self::distances`], for a check: up to a distance that is known nothing is searched
    /// closely, and it is the least that is returned as a lower bound. The mean is known closely
    /// before something is refused, roughly at first.
    #[must_use]
    pub fn check_distances(&self, known: f64, other: &Self, closely: bool) -> Distances {
        let triangles = self.corners.len().max(other.corners.len());
        self.measure(known, other, samples(triangles, closely))
    }

    fn measure(&self, known: f64, other: &Self, samples: usize) -> Distances {
        if self.corners.is_empty() || other.corners.is_empty() {
            let is_same = self.corners.len() == other.corners.len();
            let distance = if is_same { 0.0 } else { f64::INFINITY };
            return Distances { lower: distance.max(known), upper: distance, rms: distance };
        }
        let [per_triangle, per_input, besides] = Limits::DEFAULT.boxes_per_level;
        let size = FarthestSearch::for_size(self.diagonal.max(other.diagonal));
        let search = FarthestSearch { boxes: [per_triangle + per_input, besides], ..size };
        let one_way = |from: &Self, to: &Self| {
            let to = MovingSurface { triangles: to, tree: &to.tree };
            let of = |i: usize| (from.corners(i as u32), NONE);
            let difference = Difference::new(from.areas.clone(), from.area, of);
            let estimates = difference.estimate(&to);
            let sampled = difference.sample(&estimates, &to, samples);
            let of = |i: usize| (from.corners(i as u32), estimates[i].near);
            let known = known.max(sampled.max_distance);
            (search.farthest_with_hints(known, from.corners.len(), of, &to), sampled)
        };
        let ((there, there_sampled), (back, back_sampled)) =
            rayon::join(|| one_way(self, other), || one_way(other, self));
        let upper = there.upper.max(back.upper);
        // Rounding errors of coordinates are no distances.
        let upper = if upper <= 2.0 * search.floor { 0.0 } else { upper };
        let mean_square = |sampled: Sampled| sampled.mean_square;
        let rms = mean_square(there_sampled).max(mean_square(back_sampled)).sqrt().min(upper);
        Distances { lower: there.lower.max(back.lower), upper, rms }
    }
}

impl Triangles for Measurable {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.corners[triangle as usize].map(to_dvec3)
    }
    #[inline]
    fn is_live(&self, _: u32) -> bool {
        true
    }
}
