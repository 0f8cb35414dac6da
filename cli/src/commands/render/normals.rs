//! Normals for corners that the file gives none: rounded over gentle edges, kept apart at sharp
//! ones.

use lodc_mesh::{OrientedTriangle, PositionIds};
use rayon::prelude::*;

/// Cosine of the angle between two triangles from which an edge counts as sharp: 50 degrees.
const SHARP: f64 = 0.642_787_609_686_539_3;
/// Around a position with more triangles than this all are averaged, sharp edges or not: time would
/// grow as a square.
const CROWD: usize = 256;

/// A normal of length one of every triangle; zero where it has no area.
pub(super) fn flat(triangles: &[OrientedTriangle], positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    triangles.par_iter().map(|t| unit(area(t, positions))).collect()
}

/// A normal for every corner of every triangle. `points` identifies the mesh's positions.
pub(super) fn smooth(
    triangles: &[OrientedTriangle],
    positions: &[[f64; 3]],
    points: &PositionIds,
) -> Vec<[[f64; 3]; 3]> {
    let areas: Vec<[f64; 3]> = triangles.par_iter().map(|t| area(t, positions)).collect();
    let units: Vec<[f64; 3]> = areas.par_iter().map(|&a| unit(a)).collect();
    let around = Around::new(triangles, points);
    let corner = |t: usize, v: u32| {
        let neighbours = around.of(points.of_vertex[v as usize]);
        let crowd = neighbours.len() > CROWD;
        let mut sum = [0.0; 3];
        for &n in neighbours {
            let n = n as usize;
            if crowd || dot(units[n], units[t]) >= SHARP {
                sum = std::array::from_fn(|i| sum[i] + areas[n][i]);
            }
        }
        let normal = unit(sum);
        if normal == [0.0; 3] { units[t] } else { normal }
    };
    triangles.par_iter().enumerate().map(|(t, tri)| tri.corners.map(|v| corner(t, v))).collect()
}

/// The triangles around every position.
struct Around {
    ends: Vec<u32>,
    triangles: Vec<u32>,
}

impl Around {
    fn new(triangles: &[OrientedTriangle], points: &PositionIds) -> Self {
        let mut ends = vec![0u32; points.first_vertex.len() + 1];
        let of = |v: u32| points.of_vertex[v as usize] as usize;
        triangles.iter().flat_map(|t| t.corners).for_each(|v| ends[of(v) + 1] += 1);
        for i in 1..ends.len() {
            ends[i] += ends[i - 1];
        }
        let mut next = ends.clone();
        let mut sorted = vec![0; 3 * triangles.len()];
        for (number, t) in (0..).zip(triangles) {
            for v in t.corners {
                sorted[next[of(v)] as usize] = number;
                next[of(v)] += 1;
            }
        }
        Self { ends, triangles: sorted }
    }
    fn of(&self, point: u32) -> &[u32] {
        &self.triangles[self.ends[point as usize] as usize..self.ends[point as usize + 1] as usize]
    }
}

/// Twice the area along the normal.
fn area(t: &OrientedTriangle, positions: &[[f64; 3]]) -> [f64; 3] {
    let [a, b, c] = t.corners.map(|v| positions[v as usize]);
    let (u, v): ([f64; 3], [f64; 3]) =
        (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Of length one, or zero.
pub(super) fn unit(v: [f64; 3]) -> [f64; 3] {
    // Scaled first, so that squares of tiny triangles do not vanish.
    let size = v.iter().fold(0.0f64, |s, c| s.max(c.abs()));
    if size == 0.0 || !size.is_finite() {
        return [0.0; 3];
    }
    let v = v.map(|c| c / size);
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}

#[cfg(test)]
mod tests {
    use super::super::cells::whole;
    use super::*;

    /// Triangles, positions and rounded normals of a shape.
    type Shape = (Vec<OrientedTriangle>, Vec<[f64; 3]>, Vec<[[f64; 3]; 3]>);

    fn of(name: &str) -> Shape {
        let mesh = lodc_fixtures::named(name).expect("a shape");
        let positions: Vec<[f64; 3]> = mesh.positions().iter().map(|p| p.map(f64::from)).collect();
        let triangles = whole(&mesh);
        let normals = smooth(&triangles, &positions, &PositionIds::new(mesh.positions()));
        (triangles, positions, normals)
    }

    #[test]
    fn a_cube_keeps_its_edges_and_a_sphere_is_round() {
        let (triangles, positions, normals) = of("cube");
        for (flat, corners) in flat(&triangles, &positions).iter().zip(&normals) {
            assert!(corners.iter().all(|n| dot(*n, *flat) > 0.999_999), "{flat:?} {corners:?}");
        }
        let (triangles, positions, normals) = of("icosphere");
        for (t, corners) in triangles.iter().zip(&normals) {
            for (v, n) in t.corners.iter().zip(corners) {
                assert!(dot(unit(positions[*v as usize]), *n) > 0.99);
            }
        }
    }
}
