//! A triangle in space, and the place in it that is nearest to a point.

use glam::Vec3;

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

    /// The nearest point of the triangle: shares of the second and third corner, and the squared
    /// distance.
    #[inline]
    pub(super) fn locate(&self, point: Vec3) -> ([f32; 2], f32) {
        let r = point - self.origin;
        let (u, v) = (r.dot(self.dual[0]), r.dot(self.dual[1]));
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && self.dual[0] != Vec3::ZERO;
        let at = if inside { [u, v] } else { self.on_edges(r) };
        (at, (self.edges[0] * at[0] + self.edges[1] * at[1] - r).length_squared())
    }

    /// The nearest point on the edges. `r` is the query point relative to the origin.
    fn on_edges(&self, r: Vec3) -> [f32; 2] {
        let [e1, e2] = self.edges;
        let s = (r.dot(e1) * self.inverse[0]).clamp(0.0, 1.0);
        let t = (r.dot(e2) * self.inverse[1]).clamp(0.0, 1.0);
        let w = ((r - e1).dot(e2 - e1) * self.inverse[2]).clamp(0.0, 1.0);
        let mut best = ([s, 0.0], (e1 * s - r).length_squared());
        for at in [[0.0, t], [1.0 - w, w]] {
            let squared = (e1 * at[0] + e2 * at[1] - r).length_squared();
            if squared < best.1 {
                best = (at, squared);
            }
        }
        best.0
    }
}

#[cfg(test)]
mod tests {
    use super::Placed;
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
            let (at, squared) = placed.locate(query);
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
