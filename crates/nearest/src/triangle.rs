//! The closest point of a triangle to a point, and their distance, for degenerate triangles, too
//! (Ericson 2005, section 5.1.5).

use glam::DVec3;

/// The feature of a triangle that its closest point to a given point is on.
enum ClosestFeature {
    Corner(usize),
    /// The edge from a corner to another, with the share of the way.
    Edge([usize; 2], f64),
    /// The inside, with the weights of the corners, not scaled to a sum of 1.
    Inside([f64; 3]),
    /// An edge of a triangle without area; which one is not decided.
    Degenerate,
}

const EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

#[inline]
fn closest_feature(p: DVec3, [a, b, c]: [DVec3; 3]) -> ClosestFeature {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ClosestFeature::Corner(0);
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return ClosestFeature::Corner(1);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return ClosestFeature::Corner(2);
    }
    // Where the sine of the angle is below 1e-10, what follows would divide rounding errors.
    let sine_squared = ab.cross(ac).length_squared();
    if sine_squared <= 1e-20 * ab.length_squared() * ac.length_squared() {
        return ClosestFeature::Degenerate;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return ClosestFeature::Edge([0, 1], d1 / (d1 - d3));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return ClosestFeature::Edge([0, 2], d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    let (along_b, along_c) = (d4 - d3, d5 - d6);
    if va <= 0.0 && along_b >= 0.0 && along_c >= 0.0 {
        return ClosestFeature::Edge([1, 2], along_b / (along_b + along_c));
    }
    ClosestFeature::Inside([va, vb, vc])
}

/// Returns the squared distance from a point to a triangle.
#[inline]
#[must_use]
pub fn distance_squared(p: DVec3, t: [DVec3; 3]) -> f64 {
    match closest_feature(p, t) {
        ClosestFeature::Corner(k) => (p - t[k]).length_squared(),
        ClosestFeature::Edge([i, j], share) => (p - t[i] - (t[j] - t[i]) * share).length_squared(),
        ClosestFeature::Inside(_) => {
            let normal = (t[1] - t[0]).cross(t[2] - t[0]);
            let height = (p - t[0]).dot(normal);
            height * height / normal.length_squared()
        }
        ClosestFeature::Degenerate => {
            EDGES.iter().map(|&e| on_edge(p, t, e).1).fold(f64::INFINITY, f64::min)
        }
    }
}

/// Returns false if a triangle's bounding box is farther from a point than a squared distance: then
/// the triangle is, too. Much cheaper than [`distance_squared`].
#[inline]
pub(crate) fn may_be_within(p: DVec3, [a, b, c]: [DVec3; 3], squared: f64) -> bool {
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let gap_squared = (low - p).max(p - high).max(DVec3::ZERO).length_squared();
    // Lowered by more than rounding may lower the exact distance.
    gap_squared * (1.0 - 1e-9) <= squared
}

/// Returns whether a triangle is within a squared distance of a point.
#[inline]
#[must_use]
pub fn is_within(p: DVec3, t: [DVec3; 3], squared: f64) -> bool {
    may_be_within(p, t, squared) && distance_squared(p, t) <= squared
}

/// Returns the closest point of a triangle as barycentric coordinates, and its squared distance.
#[inline]
#[must_use]
pub fn closest(p: DVec3, t: [DVec3; 3]) -> ([f64; 3], f64) {
    let on = |[i, j]: [usize; 2], share: f64| {
        let mut coordinates = [0.0; 3];
        (coordinates[i], coordinates[j]) = (1.0 - share, share);
        coordinates
    };
    let coordinates = match closest_feature(p, t) {
        ClosestFeature::Corner(k) => on([k, (k + 1) % 3], 0.0),
        ClosestFeature::Edge(edge, share) => on(edge, share),
        ClosestFeature::Inside([u, v, w]) => {
            let sum = u + v + w;
            [u / sum, v / sum, w / sum]
        }
        ClosestFeature::Degenerate => {
            let candidates = EDGES.map(|edge| (on_edge(p, t, edge), edge));
            let nearest = candidates.into_iter().min_by(|a, b| a.0.1.total_cmp(&b.0.1));
            nearest.map_or([1.0, 0.0, 0.0], |((share, _), edge)| on(edge, share))
        }
    };
    (coordinates, (point_at(t, coordinates) - p).length_squared())
}

/// Returns the share of the way along an edge to its closest point, and its squared distance.
fn on_edge(p: DVec3, t: [DVec3; 3], [i, j]: [usize; 2]) -> (f64, f64) {
    let (from, edge) = (t[i], t[j] - t[i]);
    let length = edge.length_squared();
    let share = if length > 0.0 { ((p - from).dot(edge) / length).clamp(0.0, 1.0) } else { 0.0 };
    (share, (p - from - edge * share).length_squared())
}

/// Returns the point of a triangle with given barycentric coordinates.
#[inline]
#[must_use]
pub fn point_at([a, b, c]: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    a * u + b * v + c * w
}

/// Returns the centroid of a triangle.
#[inline]
#[must_use]
pub fn centroid([a, b, c]: [DVec3; 3]) -> DVec3 {
    (a + b + c) * (1.0 / 3.0)
}

/// Returns the squared length of a triangle's longest edge.
#[inline]
#[must_use]
pub fn longest_edge_squared([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared())
}

/// Returns the area of a triangle.
#[inline]
#[must_use]
pub fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Asserts a squared distance, whichever corner comes first, and that the closest point has it.
    fn assert_distance(p: DVec3, t: [DVec3; 3], squared: f64) {
        for k in 0..3 {
            let turned = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
            assert!((distance_squared(p, turned) - squared).abs() < 1e-12, "{p}");
            let (coordinates, found) = closest(p, turned);
            assert!((found - squared).abs() < 1e-12, "{p}");
            assert!((coordinates.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{coordinates:?}");
            assert!(coordinates.iter().all(|&x| (0.0..=1.0).contains(&x)), "{coordinates:?}");
        }
    }

    #[test]
    fn every_region_of_a_triangle_is_right() {
        let t = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        for (p, squared) in [
            ([1.0, 1.0, 3.0], 9.0),
            ([-3.0, -4.0, 0.0], 25.0),
            ([6.0, -1.0, 2.0], 9.0),
            ([6.0, 0.0, 1.0], 5.0),
            ([0.0, 7.0, 0.0], 9.0),
            ([2.0, -2.0, 1.0], 5.0),
            ([-2.0, 1.0, 0.0], 4.0),
            ([3.0, 3.0, 0.0], 2.0),
            ([4.0, 4.0, 0.0], 8.0),
        ] {
            assert_distance(DVec3::from(p), t, squared);
        }
    }

    #[test]
    fn boxes_change_no_answer() {
        let mut random = lodc_mesh::SplitMix64::new(5);
        let mut point = || DVec3::from_array([(); 3].map(|()| f64::from(random.unit())));
        for _ in 0..2000 {
            let (p, t) = (point() * 2.0, [point(), point(), point()]);
            let squared = distance_squared(p, t);
            assert!(is_within(p, t, squared) && !is_within(p, t, squared.next_down()));
        }
    }

    #[test]
    fn a_triangle_without_area_is_its_edges() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::X * 3.0];
        assert_distance(DVec3::new(2.0, 2.0, 0.0), t, 4.0);
        assert_distance(DVec3::new(5.0, 0.0, 0.0), [DVec3::X; 3], 16.0);
        assert_distance(DVec3::new(0.5, 1.0, 0.0), [DVec3::ZERO, DVec3::X, DVec3::X], 1.0);
    }
}
