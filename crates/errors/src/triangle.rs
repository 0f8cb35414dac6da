//! Distances between points and triangles.

use glam::DVec3;

/// Returns the squared distance from a point to a triangle, which may be degenerate (closest point
/// by regions, Ericson 2005, section 5.1.5).
#[inline]
pub(crate) fn distance_squared(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ap.length_squared();
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return bp.length_squared();
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return cp.length_squared();
    }
    let normal = ab.cross(ac);
    let area = normal.length_squared();
    if area <= 1e-20 * ab.length_squared() * ac.length_squared() {
        return to_edge(p, a, b).min(to_edge(p, b, c)).min(to_edge(p, a, c));
    }
    if d1 * d4 <= d3 * d2 && d1 >= 0.0 && d3 <= 0.0 {
        return (ap - ab * (d1 / (d1 - d3))).length_squared();
    }
    if d5 * d2 <= d1 * d6 && d2 >= 0.0 && d6 <= 0.0 {
        return (ap - ac * (d2 / (d2 - d6))).length_squared();
    }
    let (along_b, along_c) = (d4 - d3, d5 - d6);
    if d3 * d6 <= d5 * d4 && along_b >= 0.0 && along_c >= 0.0 {
        return (bp - (c - b) * (along_b / (along_b + along_c))).length_squared();
    }
    let height = ap.dot(normal);
    height * height / area
}

#[inline]
fn to_edge(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (ab, ap) = (b - a, p - a);
    let length = ab.length_squared();
    let t = if length > 0.0 { (ap.dot(ab) / length).clamp(0.0, 1.0) } else { 0.0 };
    (ap - ab * t).length_squared()
}

/// Returns the centroid of a triangle.
#[inline]
pub(crate) fn centroid([a, b, c]: [DVec3; 3]) -> DVec3 {
    (a + b + c) * (1.0 / 3.0)
}

/// Returns the area of a triangle.
pub(crate) fn area([a, b, c]: [DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_region_of_a_triangle_is_right() {
        let t = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        for (p, squared) in [
            (DVec3::new(1.0, 1.0, 3.0), 9.0),
            (DVec3::new(-3.0, -4.0, 0.0), 25.0),
            (DVec3::new(6.0, -1.0, 2.0), 9.0),
            (DVec3::new(0.0, 7.0, 0.0), 9.0),
            (DVec3::new(2.0, -2.0, 1.0), 5.0),
            (DVec3::new(-2.0, 1.0, 0.0), 4.0),
            (DVec3::new(3.0, 3.0, 0.0), 2.0),
        ] {
            for k in 0..3 {
                let turned = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
                assert!((distance_squared(p, turned) - squared).abs() < 1e-12, "{p}");
            }
        }
    }

    #[test]
    fn a_degenerate_triangle_is_its_edges() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::X * 3.0];
        assert_eq!(distance_squared(DVec3::new(2.0, 2.0, 0.0), t), 4.0);
        assert_eq!(distance_squared(DVec3::new(5.0, 0.0, 0.0), [DVec3::X; 3]), 16.0);
    }
}
