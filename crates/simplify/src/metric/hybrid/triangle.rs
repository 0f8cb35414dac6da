//! A triangle prepared for finding its points nearest to four samples at once.

use super::vectors::Vec3x4;
use glam::{BVec4A, Vec3, Vec4};

/// Triangles whose height is at most this share of their longest edge are taken for segments:
/// points in them would be lost in rounding. Chosen by hand, some thousand times the rounding error
/// of an edge.
const THIN: f32 = 1e-3;

/// A triangle prepared for nearest-point queries.
#[derive(Clone, Copy, Debug)]
pub(super) struct PreparedTriangle {
    origin: Vec3,
    edges: [Vec3; 2],
    /// The unit normal; zero if the triangle has no area.
    pub(super) normal: Vec3,
    /// The dual basis of the edges; zero if the triangle is thin.
    dual: [Vec3; 2],
    /// The distances of the second, the third and the first corner from the edges opposite to them.
    heights: [f32; 3],
    /// Inverse squared lengths of the two edges from the first corner and of the third edge; zero
    /// for edges without length.
    inverse: [f32; 3],
}

/// Points of a triangle, one for each of four samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointsInTriangle {
    /// Shares of the second and third corner.
    pub(super) at: [Vec4; 2],
    /// Squared distances from the samples.
    pub(super) squared: Vec4,
}

impl PointsInTriangle {
    #[inline]
    fn select(mask: BVec4A, yes: Self, no: Self) -> Self {
        let at = [0, 1].map(|i| Vec4::select(mask, yes.at[i], no.at[i]));
        Self { at, squared: Vec4::select(mask, yes.squared, no.squared) }
    }
}

impl PreparedTriangle {
    pub(super) fn new(corners: [Vec3; 3]) -> Self {
        let [e1, e2] = [corners[1] - corners[0], corners[2] - corners[0]];
        let n = e1.cross(e2);
        let invert = |x: f32| Some(1.0 / x).filter(|inverse| inverse.is_finite()).unwrap_or(0.0);
        let inverse = invert(n.length_squared());
        let longest = e1.length_squared().max(e2.length_squared()).max((e2 - e1).length_squared());
        // Twice the area is the longest edge times the height over it.
        let is_thin = n.length_squared() <= THIN * THIN * longest * longest;
        let [in_e1, in_e2] = [e2.cross(n) * inverse, n.cross(e1) * inverse];
        let dual = if is_thin { [Vec3::ZERO; 2] } else { [in_e1, in_e2] };
        let heights = [dual[0], dual[1], dual[0] + dual[1]].map(|d| invert(d.length()));
        let lengths = [e1, e2, e2 - e1].map(|e| invert(e.length_squared()));
        let normal = n * inverse.sqrt();
        Self { origin: corners[0], edges: [e1, e2], normal, dual, heights, inverse: lengths }
    }

    /// The point at shares of the second and third corner.
    pub(super) fn at(&self, [u, v]: [f32; 2]) -> Vec3 {
        self.origin + self.edges[0] * u + self.edges[1] * v
    }

    /// The area in squared working units.
    pub(super) fn area(&self) -> f32 {
        0.5 * self.edges[0].cross(self.edges[1]).length()
    }

    /// The points of the triangle that are nearest to four samples; none if no sample can be nearer
    /// than the square root of its number in `limits`.
    #[inline]
    pub(super) fn nearest_to(&self, samples: Vec3x4, limits: Vec4) -> Option<PointsInTriangle> {
        let r = samples.minus(self.origin);
        let [u, v] = self.dual.map(|d| r.dot_with(d));
        let is_thin = self.dual[0] == Vec3::ZERO;
        let mut best = PointsInTriangle { at: [u, v], squared: Vec4::INFINITY };
        let mut within = BVec4A::default();
        if !is_thin {
            let w = Vec4::ONE - u - v;
            let above = r.dot_with(self.normal);
            best.squared = above * above;
            // A lower bound of the distance in the plane: from the edge that is farthest inside.
            let [of_u, of_v, of_w] = self.heights;
            let outside = (u * -of_u).max(v * -of_v).max(w * -of_w).max(Vec4::ZERO);
            if !(best.squared + outside * outside).cmplt(limits).any() {
                return None;
            }
            within = outside.cmple(Vec4::ZERO);
            if within.all() {
                return Some(best);
            }
        }
        let [e1, e2] = self.edges;
        let on = |at: [Vec4; 2]| {
            let away = r.minus_span(self.edges, at);
            PointsInTriangle { at, squared: away.dot(away) }
        };
        let share = |r: Vec3x4, edge: Vec3, inverse: f32| {
            (r.dot_with(edge) * inverse).max(Vec4::ZERO).min(Vec4::ONE)
        };
        let s = share(r, e1, self.inverse[0]);
        let t = share(r, e2, self.inverse[1]);
        let w = share(r.minus(e1), e2 - e1, self.inverse[2]);
        let mut on_edges = on([s, Vec4::ZERO]);
        for at in [[Vec4::ZERO, t], [Vec4::ONE - w, w]] {
            let other = on(at);
            let nearer = other.squared.cmplt(on_edges.squared);
            on_edges = PointsInTriangle::select(nearer, other, on_edges);
        }
        Some(PointsInTriangle::select(within, best, on_edges))
    }
}

#[cfg(test)]
mod tests {
    use super::{PreparedTriangle, Vec3x4};
    use glam::{Vec3, Vec4};
    use lodc_fixtures::Rng;

    #[test]
    fn the_nearest_point_is_the_nearest_of_many() {
        let mut random = Rng::new(3);
        let mut point = || Vec3::new(random.unit(), random.unit(), random.unit());
        for round in 0..200 {
            let mut corners = [point(), point(), point()];
            if round % 4 == 0 {
                // No area: a segment.
                corners[2] = corners[0].lerp(corners[1], 0.3);
            }
            let triangle = PreparedTriangle::new(corners);
            let query = point() * 2.0;
            let samples = Vec3x4::new(&[query; 4]);
            let found = triangle.nearest_to(samples, Vec4::INFINITY).expect("no limit");
            let (at, squared) = (found.at.map(|lane| lane.z), found.squared.z);
            assert!(at.iter().all(|&s| s >= 0.0) && at[0] + at[1] < 1.0 + 1e-6, "{at:?}");
            assert!((triangle.at(at).distance_squared(query) - squared).abs() < 1e-5);
            let limits = Vec4::splat(squared * 1.001 + 1e-6);
            assert!(triangle.nearest_to(samples, limits).is_some());
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let other = triangle.at([i as f32 / 20.0, j as f32 / 20.0]);
                    assert!(other.distance_squared(query) > squared - 1e-5);
                }
            }
        }
    }
}
