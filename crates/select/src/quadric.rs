//! Accumulated quadric error of a collapse sequence (Garland and Heckbert 1997): the squared
//! distances of vertices from the planes of the faces that became theirs, summed over area.

use glam::DVec3;
use lodc_mesh::{CollapseSequence, Csr, PositionIds};

/// A sum of squared distances to planes, as a symmetric 4×4 matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Quadric {
    /// xx, xy, xz, yy, yz, zz.
    quadratic: [f64; 6],
    linear: DVec3,
    constant: f64,
}

impl Quadric {
    /// The squared distance to the plane through a point, times a weight.
    fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let d = -normal.dot(point);
        let [x, y, z] = normal.to_array();
        let products = [x * x, x * y, x * z, y * y, y * z, z * z];
        Self {
            quadratic: products.map(|p| weight * p),
            linear: weight * d * normal,
            constant: weight * d * d,
        }
    }

    fn add(&mut self, other: &Self) {
        for (a, b) in self.quadratic.iter_mut().zip(other.quadratic) {
            *a += b;
        }
        self.linear += other.linear;
        self.constant += other.constant;
    }

    /// The sum at a point.
    fn at(&self, p: DVec3) -> f64 {
        let [xx, xy, xz, yy, yz, zz] = self.quadratic;
        let rows = DVec3::new(
            xx * p.x + xy * p.y + xz * p.z,
            xy * p.x + yy * p.y + yz * p.z,
            xz * p.x + yz * p.y + zz * p.z,
        );
        p.dot(rows) + 2.0 * p.dot(self.linear) + self.constant
    }
}

/// Returns the accumulated error after each step, never falling: the sum over the faces of LOD 0
/// and their corners of a third of the face's weight times the squared distance of the corner's
/// present position from the face's plane; and the same for planes through border edges,
/// perpendicular to their faces, so that shrinking open surfaces has a cost. `weights` has the
/// weight of each face, in units of area.
#[must_use]
pub fn accumulated_error(
    triangles: &[[u32; 3]],
    positions: &[DVec3],
    ids: &PositionIds,
    weights: &[f64],
    collapses: &CollapseSequence,
) -> Vec<f64> {
    // Relative to the middle, so that large coordinates do not round small distances away.
    let middle = positions.iter().sum::<DVec3>() / positions.len().max(1) as f64;
    let at = |v: u32| positions[v as usize] - middle;
    let mut quadrics = vec![Quadric::default(); positions.len()];
    for (&t, &weight) in triangles.iter().zip(weights) {
        let [a, b, c] = t.map(at);
        let plane = Quadric::plane((b - a).cross(c - a).normalize_or_zero(), a, weight / 3.0);
        t.iter().for_each(|&v| quadrics[v as usize].add(&plane));
    }
    for (triangle, [from, to]) in border_edges(triangles, ids) {
        let [a, b, c] = triangles[triangle].map(at);
        let normal = (b - a).cross(c - a);
        let area = 0.5 * normal.length();
        if area > 0.0 {
            let edge = at(to) - at(from);
            let outward = normal.cross(edge).normalize_or_zero();
            let weight = 0.5 * edge.length_squared() * weights[triangle] / area;
            let plane = Quadric::plane(outward, at(from), weight);
            [from, to].iter().for_each(|&v| quadrics[v as usize].add(&plane));
        }
    }
    let mut sum = 0.0;
    let mut largest = 0.0f64;
    let mut record = 0;
    let targets = collapses.targets();
    let after_step = |&end: &u32| {
        for (source, &target) in (record..end).zip(&targets[record as usize..end as usize]) {
            let quadric = quadrics[source as usize];
            sum += quadric.at(at(target)) - quadric.at(at(source));
            quadrics[target as usize].add(&quadric);
        }
        record = end;
        largest = largest.max(sum);
        largest
    };
    collapses.parts().step_ends.iter().map(after_step).collect()
}

/// The edges with one triangle, each with the number of that, in the order of the triangles.
fn border_edges(triangles: &[[u32; 3]], ids: &PositionIds) -> Vec<(usize, [u32; 2])> {
    let point = |v: u32| ids.of_vertex[v as usize];
    let edges = || {
        let triangle_edges = |(t, triangle): (usize, &[u32; 3])| {
            let [a, b, c] = *triangle;
            [(t, [a, b]), (t, [b, c]), (t, [c, a])]
        };
        triangles.iter().enumerate().flat_map(triangle_edges)
    };
    let ends = |[a, b]: [u32; 2]| (point(a).min(point(b)), point(a).max(point(b)));
    // For each position the larger ends of the edges whose smaller end it is, rising.
    let mut larger_ends = Csr::new(ids.first_vertex.len(), edges().map(|(_, e)| ends(e)));
    for row in 0..larger_ends.rows() as u32 {
        let range = larger_ends.range(row);
        larger_ends.values[range].sort_unstable();
    }
    let is_border = |edge: [u32; 2]| {
        let (low, high) = ends(edge);
        let row = larger_ends.row(low);
        let first = row.partition_point(|&v| v < high);
        row.get(first + 1) != Some(&high)
    };
    edges().filter(|(_, edge)| is_border(*edge)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::SequenceParts;

    /// A strip of squares in the plane z = 0 and the sequence that removes its vertices in order.
    fn strip() -> (Vec<[u32; 3]>, Vec<DVec3>, CollapseSequence) {
        let point = |i: u32| DVec3::new(f64::from(i / 2), f64::from(i % 2), 0.0);
        let positions: Vec<DVec3> = (0..6).map(point).collect();
        let square = |i: u32| [[i, i + 2, i + 1], [i + 1, i + 2, i + 3]];
        let triangles = [square(0), square(2)].concat();
        let collapses = CollapseSequence::try_from(SequenceParts {
            targets: vec![2, 3, 4, 5, 5],
            step_ends: vec![1, 2, 3, 4, 5],
            step_errors: vec![1.0; 5],
            step_triangles: vec![3, 2, 1, 0, 0],
            triangles: 4,
            ..SequenceParts::default()
        });
        (triangles, positions, collapses.expect("steps in order"))
    }

    #[test]
    fn a_border_costs_what_it_loses_and_a_plane_costs_nothing() {
        let (triangles, positions, collapses) = strip();
        let single: Vec<[f32; 3]> = positions.iter().map(|p| p.as_vec3().to_array()).collect();
        let ids = PositionIds::new(&single);
        assert_eq!(border_edges(&triangles, &ids).len(), 6);
        let error = accumulated_error(&triangles, &positions, &ids, &[0.5; 4], &collapses);
        // The first vertex moves by 1 off its border edge of length 1: half that, squared, at this
        // end.
        assert!((error[0] - 0.5).abs() < 1e-12, "{error:?}");
        assert!(error.windows(2).all(|w| w[0] <= w[1]), "{error:?}");
        let none = accumulated_error(&triangles, &positions, &ids, &[0.0; 4], &collapses);
        assert_eq!(none, [0.0; 5]);
    }

    #[test]
    fn a_quadric_is_the_squared_distance() {
        let normal = DVec3::new(1.0, 2.0, 2.0) / 3.0;
        let q = Quadric::plane(normal, DVec3::new(1.0, 1.0, 0.0), 2.0);
        let p = DVec3::new(4.0, -1.0, 7.0);
        let distance = normal.dot(p - DVec3::new(1.0, 1.0, 0.0));
        assert!((q.at(p) - 2.0 * distance * distance).abs() < 1e-9);
    }
}
