//! The distance between two surfaces that need not have a point in common: of levels that are not
//! of the collapse sequence, since their vertices were moved, rounded or chosen otherwise.

use crate::check::{CLOSE_SAMPLES, usual_samples};
use crate::difference::Difference;
use crate::input::to_dvec3;
use crate::settings::Limits;
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{
    FarthestSearch, MovingSurface, MovingTree, Query, Surface, Triangles, area, morton_order,
};

/// A triangle surface, ready to be measured from others. Triangles that are a line or a point by
/// their corners have no points to measure, but others are as near to them as to any: a part that
/// a target unfolds is such lines at rest.
#[derive(Clone, Debug)]
pub struct Measurable {
    /// The corners of each triangle; neighbours in space are near each other. Lines and points come
    /// last.
    corners: Vec<[[f32; 3]; 3]>,
    /// The areas of the others.
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
        let (all, thin): (Vec<_>, Vec<_>) = triangles.into_iter().partition(has_area);
        let order = morton_order(0..all.len() as u32, |t| all[t as usize]);
        let mut corners: Vec<[[f32; 3]; 3]> = order.iter().map(|&t| all[t as usize]).collect();
        let areas: Vec<f32> = corners.iter().map(|&t| area(t.map(to_dvec3)) as f32).collect();
        corners.extend(thin);
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

    /// The distance of a point from the surface; infinite if it has no triangles.
    #[must_use]
    pub fn distance_to(&self, point: [f32; 3]) -> f64 {
        let surface = MovingSurface { triangles: self, tree: &self.tree };
        let (point, hint, max_boxes) = (to_dvec3(point), NONE, u32::MAX);
        surface.near(Query { point, hint, enough: 0.0, max_boxes }).0.squared.sqrt()
    }

    /// Measures how far another surface is from this one.
    #[must_use]
    pub fn distances(&self, other: &Self) -> Distances {
        self.measure(0.0, other, Limits::DEFAULT.samples)
    }

    /// As [`Self::distances`], for a check: up to a distance that is known nothing is searched
    /// closely, and it is the least that is returned as a lower bound. `closely` asks for a mean of
    /// many samples, before something is refused; few do at first.
    #[must_use]
    pub fn check_distances(&self, known: f64, other: &Self, closely: bool) -> Distances {
        let triangles = self.areas.len().max(other.areas.len());
        self.measure(known, other, if closely { CLOSE_SAMPLES } else { usual_samples(triangles) })
    }

    fn measure(&self, known: f64, other: &Self, samples: usize) -> Distances {
        let is_lost = |from: &Self, to: &Self| !from.areas.is_empty() && to.corners.is_empty();
        let are_empty = self.areas.is_empty() && other.areas.is_empty();
        if are_empty || is_lost(self, other) || is_lost(other, self) {
            let distance = if are_empty { 0.0 } else { f64::INFINITY };
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
            (search.farthest_with_hints(known, from.areas.len(), of, &to), sampled)
        };
        let ((there, there_sampled), (back, back_sampled)) =
            rayon::join(|| one_way(self, other), || one_way(other, self));
        let upper = there.upper.max(back.upper);
        // Rounding errors of coordinates are no distances.
        let upper = if upper <= 2.0 * search.floor { 0.0 } else { upper };
        let mean_square = there_sampled.mean_square.max(back_sampled.mean_square);
        let rms = mean_square.sqrt().min(upper);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_a_line_at_rest_is_near_but_not_measured() {
        let at = |x: f32, y: f32| [x, y, 0.0];
        // A fan that is folded into a curve, and a level of it that cuts the curve off.
        let folded = Measurable::new([
            [at(0.0, 0.0), at(1.0, 0.25), at(1.0, 0.25)],
            [at(1.0, 0.25), at(2.0, 0.0), at(2.0, 0.0)],
        ]);
        let cut = Measurable::new([[at(0.0, 0.0), at(1.0, 0.25), at(2.0, 0.0)]]);
        let Distances { lower, upper, .. } = folded.distances(&cut);
        assert!(lower > 0.2 && upper < 0.26, "{lower} {upper}");
        let nothing = Measurable::new([]);
        assert_eq!(folded.distances(&nothing).upper, 0.0, "none of it is seen");
        assert_eq!(cut.distances(&nothing).upper, f64::INFINITY);
        assert_eq!(cut.distance_to(at(1.0, 1.25)), 1.0);
        assert_eq!(folded.distance_to(at(1.0, 1.25)), 1.0);
    }
}
