//! A triangle in space, and the place in it that is nearest to a point.

use super::vectors::{Places, Vec3x4};
use glam::{Vec3, Vec4};

/// A triangle prepared for nearest-point queries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    origin: Vec3,
    edges: [Vec3; 2],
    /// The dual basis of the edges; zero if the triangle has no area.
    dual: [Vec3; 2],
    /// Inverse squared lengths of the edges from the origin and of the third; zero for points.
    inverse: [f32; 3],
}

impl Placed {
    /// Prepares a triangle and returns its unit normal, zero if it has no area.
    pub(super) fn new(corners: [Vec3; 3]) -> (Self, Vec3) {
        let [e1, e2] = [corners[1] - corners[0], corners[2] - corners[0]];
        let n = e1.cross(e2);
        let invert = |x: f32| if x > 0.0 { 1.0 / x } else { 0.0 };
        let inverse = invert(n.length_squared());
        let dual = [e2.cross(n) * inverse, n.cross(e1) * inverse];
        let lengths = [e1, e2, e2 - e1].map(|e| invert(e.length_squared()));
        let placed = Self { origin: corners[0], edges: [e1, e2], dual, inverse: lengths };
        (placed, n * inverse.sqrt())
    }

    /// The point at shares of the second and third corner.
    pub(super) fn at(&self, [u, v]: [f32; 2]) -> Vec3 {
        self.origin + self.edges[0] * u + self.edges[1] * v
    }

    /// The area in squared working units.
    pub(super) fn area(&self) -> f32 {
        0.5 * self.edges[0].cross(self.edges[1]).length()
    }

    /// The points of the triangle that are nearest to four points. `number` is the triangle's.
    #[inline]
    pub(super) fn locate_four(&self, points: Vec3x4, number: f32) -> Places {
        let r = points.minus(self.origin);
        let place = |at: [Vec4; 2]| {
            let away = r.minus_span(self.edges, at);
            Places { face: Vec4::splat(number), at, away, squared: away.dot(away) }
        };
        let [e1, e2] = self.edges;
        let share = |r: Vec3x4, edge: Vec3, inverse: f32| {
            (r.dot_with(edge) * inverse).max(Vec4::ZERO).min(Vec4::ONE)
        };
        let s = share(r, e1, self.inverse[0]);
        let t = share(r, e2, self.inverse[1]);
        let w = share(r.minus(e1), e2 - e1, self.inverse[2]);
        let mut best = place([s, Vec4::ZERO]);
        for at in [[Vec4::ZERO, t], [Vec4::ONE - w, w]] {
            let other = place(at);
            best = Places::select(other.squared.cmplt(best.squared), other, best);
        }
        if self.dual[0] == Vec3::ZERO {
            return best;
        }
        let (u, v) = (r.dot_with(self.dual[0]), r.dot_with(self.dual[1]));
        let within = u.cmpge(Vec4::ZERO) & v.cmpge(Vec4::ZERO) & (u + v).cmple(Vec4::ONE);
        Places::select(within, place([u, v]), best)
    }
}

#[cfg(test)]
mod tests {
    use super::{Placed, Vec3x4};
    use glam::Vec3;
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
            let (placed, _) = Placed::new(corners);
            let query = point() * 2.0;
            let found = placed.locate_four(Vec3x4::new(&[query; 4]), 0.0);
            let (at, squared) = (found.at.map(|lane| lane.z), found.squared.z);
            assert!(at.iter().all(|&s| s >= 0.0) && at[0] + at[1] < 1.0 + 1e-6, "{at:?}");
            assert!((placed.at(at).distance_squared(query) - squared).abs() < 1e-5);
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let other = placed.at([i as f32 / 20.0, j as f32 / 20.0]);
                    assert!(other.distance_squared(query) > squared - 1e-5);
                }
            }
        }
    }
}
