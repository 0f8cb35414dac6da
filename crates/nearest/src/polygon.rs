//! Convex polygons, cut by planes: which part of a polygon is within a distance of a triangle, for
//! the search in `farthest`.

use crate::triangle::distance_squared;
use glam::DVec3;
use std::f64::consts::FRAC_1_SQRT_2;

/// Most corners of a polygon: a simple one cut by the eight planes around a triangle rarely has
/// more. Chosen by hand.
const MAX_CORNERS: usize = 12;

/// Most corners of a polygon that is cut: each cut may add one. Chosen by hand.
const MAX_CORNERS_BEFORE_CUTS: usize = 6;

/// Least height above a triangle, as a share of the distance, at which a polygon that rises beyond
/// the distance is cut: higher leaves less margin beside the triangle. Chosen by hand.
const MIN_CUT_HEIGHT: f64 = 0.8;

/// A triangle that is more times as long as wide is a sliver. Chosen by hand.
const SLIVER_RATIO: f64 = 8.0;

/// A convex polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    corners: [DVec3; MAX_CORNERS],
    count: usize,
}

impl Polygon {
    pub(crate) const EMPTY: Self = Self { corners: [DVec3::ZERO; MAX_CORNERS], count: 0 };

    pub(crate) fn triangle(corners: [DVec3; 3]) -> Self {
        let mut polygon = Self::EMPTY;
        polygon.corners[..3].copy_from_slice(&corners);
        polygon.count = 3;
        polygon
    }

    pub(crate) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// Adds a corner. Returns false if there is no room.
    fn push(&mut self, corner: DVec3) -> bool {
        let Some(slot) = self.corners.get_mut(self.count) else { return false };
        *slot = corner;
        self.count += 1;
        true
    }

    /// Returns the mean of its corners, and the largest distance of a corner from it.
    pub(crate) fn disc(&self) -> (DVec3, f64) {
        let middle = self.corners().iter().sum::<DVec3>() / self.count as f64;
        let squared = self.corners().iter().map(|c| (*c - middle).length_squared());
        (middle, squared.fold(0.0, f64::max).sqrt())
    }

    /// Returns twice its area.
    pub(crate) fn double_area(&self) -> f64 {
        let c = self.corners();
        (1..c.len().max(2) - 1)
            .map(|i| (c[i] - c[0]).cross(c[i + 1] - c[0]))
            .sum::<DVec3>()
            .length()
    }

    /// Returns whether it is more than a line.
    pub(crate) fn has_area(&self) -> bool {
        self.count >= 3
    }

    /// Returns the largest distance of a corner from a triangle, and the corner. No point of the
    /// polygon is farther. 0 without corners.
    pub(crate) fn farthest_corner(&self, triangle: [DVec3; 3]) -> (f64, DVec3) {
        let distances = self.corners().iter().map(|&c| (distance_squared(c, triangle), c));
        let (squared, corner) = distances
            .fold((0.0, self.corners[0]), |best, new| if new.0 > best.0 { new } else { best });
        (squared.sqrt(), corner)
    }

    /// Returns the parts on the negative and the positive side of a plane, given by a point and a
    /// normal of length 1. A corner within `slack` of it is on both, and no side is thinner than
    /// that: slivers along common edges would be divided for ever. All is on the negative side if
    /// there is no room for more corners.
    fn cut(&self, point: DVec3, normal: DVec3, slack: f64) -> [Self; 2] {
        let mut heights = [0.0; MAX_CORNERS];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (height, &p) in heights.iter_mut().zip(self.corners()) {
            *height = (p - point).dot(normal);
            (low, high) = (low.min(*height), high.max(*height));
        }
        if high <= slack {
            return [*self, Self::EMPTY];
        }
        if low >= -slack {
            return [Self::EMPTY, *self];
        }
        let mut sides = [Self::EMPTY; 2];
        let mut fits = true;
        for i in 0..self.count {
            let previous = if i == 0 { self.count - 1 } else { i - 1 };
            let (p, q) = (self.corners[previous], self.corners[i]);
            let (h, k) = (heights[previous], heights[i]);
            if h < -slack && k > slack || h > slack && k < -slack {
                let crossing = p + (q - p) * (h / (h - k));
                fits &= sides[0].push(crossing) & sides[1].push(crossing);
            }
            if k <= slack {
                fits &= sides[0].push(q);
            }
            if k >= -slack {
                fits &= sides[1].push(q);
            }
        }
        if fits { sides } else { [*self, Self::EMPTY] }
    }

    /// Returns a part that is within a distance of a triangle, nearly all there is, and fills
    /// `pieces` with the other parts. That part is inside the triangle's prism, as high as the
    /// distance allows, and widened as far as that then allows.
    pub(crate) fn split_near(
        &self,
        [a, b, c]: [DVec3; 3],
        distance: f64,
        slack: f64,
        pieces: &mut Vec<Self>,
    ) -> Self {
        pieces.clear();
        let Some(normal) = (b - a).cross(c - a).try_normalize() else {
            pieces.push(*self);
            return Self::EMPTY;
        };
        let mut inside = *self;
        let mut cut = |point: DVec3, outwards: DVec3| {
            let [inner, outer] = inside.cut(point, outwards, slack);
            if outer.has_area() {
                inside = inner;
                pieces.push(outer);
            }
        };
        let (mut sum, mut low, mut high) = (0.0, 0.0f64, 0.0f64);
        for &p in self.corners() {
            let height = (p - a).dot(normal);
            (sum, low, high) = (sum + height, low.min(height), high.max(height));
        }
        let mut height = high.max(-low);
        if height > distance {
            let middle = (sum / self.count as f64).abs().min(distance);
            height = (MIN_CUT_HEIGHT * distance).max(0.5 * (middle + distance));
            cut(a + normal * height, normal);
            cut(a - normal * height, -normal);
        }
        // Where two planes meet at no more than a right angle, their common line is no farther from
        // the triangle than √2 times the margin.
        let margin = (distance * distance - height * height).max(0.0).sqrt();
        let margin = (margin * FRAC_1_SQRT_2 - slack).max(0.0);
        let directions = [b - a, c - b, a - c].map(DVec3::normalize_or_zero);
        for (corner, direction) in [a, b, c].into_iter().zip(directions) {
            let outwards = direction.cross(normal);
            cut(corner + outwards * margin, outwards);
        }
        for (i, corner) in [a, b, c].into_iter().enumerate() {
            let (incoming, outgoing) = (directions[(i + 2) % 3], directions[i]);
            let is_sharp = incoming.dot(outgoing) < 0.0;
            if is_sharp {
                let outwards = (incoming - outgoing).normalize_or_zero();
                cut(corner + outwards * margin, outwards);
            }
        }
        inside
    }

    /// Returns whether it has room for the corners that cutting adds.
    pub(crate) fn is_simple(&self) -> bool {
        self.count <= MAX_CORNERS_BEFORE_CUTS
    }

    /// Returns two parts with fewer corners.
    pub(crate) fn split(&self) -> [Self; 2] {
        let half = self.count / 2;
        let mut parts = [Self::EMPTY; 2];
        parts[0].corners[..=half].copy_from_slice(&self.corners[..=half]);
        parts[0].count = half + 1;
        let count_second = self.count - half;
        parts[1].corners[..count_second].copy_from_slice(&self.corners[half..self.count]);
        parts[1].corners[count_second] = self.corners[0];
        parts[1].count = count_second + 1;
        parts
    }

    /// Returns two parts: cut along a triangle's longest edge where the polygon is more times as
    /// wide as the triangle than as long, else across the middle of the longest diagonal or edge. A
    /// wide part beside slivers would else be divided into pieces as short as they are thin.
    pub(crate) fn halves(&self, [a, b, c]: [DVec3; 3]) -> [Self; 2] {
        let (longest_squared, from, to) = self.longest();
        let edges = [b - a, c - b, a - c];
        let along = edges.into_iter().fold(DVec3::ZERO, |longest, edge| {
            if edge.length_squared() > longest.length_squared() { edge } else { longest }
        });
        let length = along.length();
        let normal = (b - a).cross(c - a);
        let across = normal.cross(along).normalize_or_zero();
        let width = if length > 0.0 { normal.length() / length } else { 0.0 };
        if length > SLIVER_RATIO * width && width > 0.0 {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for p in self.corners() {
                let at = (*p - a).dot(across);
                (low, high) = (low.min(at), high.max(at));
            }
            // A thin part that stands on the triangle is long in neither of its directions.
            if (high - low) * length > longest_squared.sqrt() * width {
                return self.cut(a + across * (0.5 * low + 0.5 * high), across, 0.0);
            }
        }
        self.cut((from + to) * 0.5, (to - from).normalize_or_zero(), 0.0)
    }

    /// Returns the squared length of its longest diagonal or edge, and both ends.
    fn longest(&self) -> (f64, DVec3, DVec3) {
        let mut longest = (0.0, DVec3::ZERO, DVec3::ZERO);
        for (i, &a) in self.corners().iter().enumerate() {
            for &b in &self.corners()[i + 1..] {
                let squared = (b - a).length_squared();
                if squared > longest.0 {
                    longest = (squared, a, b);
                }
            }
        }
        longest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::SplitMix64;

    #[test]
    fn what_is_near_a_triangle_is_within_the_distance_and_nothing_is_lost() {
        let mut random = SplitMix64::new(7);
        let mut point = || DVec3::from_array([0; 3].map(|_| f64::from(random.unit())));
        let (mut nonempty, mut around) = (0, Vec::new());
        for round in 0..2_000 {
            let [triangle, corners] = [0; 2].map(|_| [0; 3].map(|_| point()));
            let distance = 0.05 * f64::from(round % 10);
            let polygon = Polygon::triangle(corners);
            let inside = polygon.split_near(triangle, distance, 1e-12, &mut around);
            assert!(inside.farthest_corner(triangle).0 <= distance + 1e-11, "{round}");
            let sum = inside.double_area() + around.iter().map(Polygon::double_area).sum::<f64>();
            let whole = polygon.double_area();
            assert!((sum - whole).abs() < 1e-9, "{round}: {sum} {whole}");
            nonempty += usize::from(inside.has_area());
        }
        assert!(nonempty > 500, "{nonempty}");
    }
}
