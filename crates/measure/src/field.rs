//! A distance field over triangles: the distance to a surface at lattice points of every triangle,
//! for colouring them in pictures.

use glam::DVec3;
use lodc_nearest::TriangleTree;
use rayon::prelude::*;

/// Largest number of parts of an edge. Chosen by hand.
const MAX_PARTS: usize = 48;
/// Largest number of points in one field, about; but each triangle has its corners. Chosen by hand:
/// 16 MB.
const MAX_POINTS: usize = 4 << 20;

/// Distances from points of some triangles to a surface. The vertices of a level of detail are
/// vertices of its input, so only points between them have distances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DistanceField {
    /// For each triangle, the number of parts of its edges.
    parts: Vec<usize>,
    /// For each triangle, the distances of its points, row by row.
    distances: Vec<Vec<f32>>,
}

impl DistanceField {
    /// Measures triangles by their corners, at steps of about `step`. Where that would be too many
    /// points, steps are longer.
    #[must_use]
    pub fn new(triangles: &[[DVec3; 3]], to: &TriangleTree, step: f64) -> Self {
        let parts_of = |&[a, b, c]: &[DVec3; 3]| {
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            if step > 0.0 { ((longest / step).ceil() as usize).clamp(1, MAX_PARTS) } else { 1 }
        };
        let mut parts: Vec<usize> = triangles.iter().map(parts_of).collect();
        let points: usize = parts.iter().map(|k| (k + 1) * (k + 2) / 2).sum();
        if points > MAX_POINTS {
            let factor = (MAX_POINTS as f64 / points as f64).sqrt();
            parts.iter_mut().for_each(|k| *k = ((*k as f64 * factor) as usize).max(1));
        }
        let distances = |(&[a, b, c], &k): (&[DVec3; 3], &usize)| -> Vec<f32> {
            let point = |s: [f64; 3]| a * s[0] + b * s[1] + c * s[2];
            lattice(k).map(|s| to.distance_squared(point(s)).sqrt() as f32).collect()
        };
        let distances = triangles.par_iter().zip(&parts).map(distances).collect();
        Self { parts, distances }
    }

    /// The largest distance; 0 without triangles.
    #[must_use]
    pub fn largest(&self) -> f32 {
        self.distances.iter().flatten().fold(0.0, |l, d| l.max(*d))
    }

    /// Cuts a triangle into the parts on which it was measured. `corner` makes a corner of a part
    /// from its shares of the triangle's corners and its distance. Three in a row are a part.
    pub fn parts<T: Copy>(&self, triangle: usize, corner: impl Fn([f64; 3], f32) -> T) -> Vec<T> {
        let k = self.parts[triangle];
        let distances = &self.distances[triangle];
        let points: Vec<T> =
            lattice(k).zip(distances).map(|(shares, &distance)| corner(shares, distance)).collect();
        let mut out = Vec::with_capacity(3 * k * k);
        let mut start = 0;
        for row in 0..k {
            let (length, next) = (k - row, start + k - row + 1);
            for i in 0..length {
                out.extend([start + i, start + i + 1, next + i].map(|p| points[p]));
                if i + 1 < length {
                    out.extend([start + i + 1, next + i + 1, next + i].map(|p| points[p]));
                }
            }
            start = next;
        }
        out
    }
}

/// The lattice points of a triangle whose edges have `k` parts, row by row, as shares of its
/// corners.
fn lattice(k: usize) -> impl Iterator<Item = [f64; 3]> {
    let part = 1.0 / k as f64;
    (0..=k).flat_map(move |row| {
        (0..=k - row).map(move |i| {
            let (b, c) = (i as f64 * part, row as f64 * part);
            [1.0 - b - c, b, c]
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_triangle_cover_it_once() {
        let triangle = [DVec3::ZERO, 6.0 * DVec3::X, 6.0 * DVec3::Y];
        let plane = TriangleTree::new(&[triangle.map(|p| p + DVec3::Z)]);
        for (step, k) in [(9.0, 1), (5.0, 2), (1.8, 5)] {
            let field = DistanceField::new(&[triangle], &plane, step);
            let point = |s: [f64; 3], distance: f32| {
                assert!((distance - 1.0).abs() < 1e-6);
                triangle[0] * s[0] + triangle[1] * s[1] + triangle[2] * s[2]
            };
            let parts = field.parts(0, point);
            assert_eq!(parts.len(), 3 * k * k);
            let area = |t: &[DVec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).z;
            let areas: Vec<f64> = parts.as_chunks::<3>().0.iter().map(area).collect();
            assert!(areas.iter().all(|a| (a - 36.0 / (k * k) as f64).abs() < 1e-9), "{areas:?}");
        }
    }

    #[test]
    fn a_triangle_is_measured_between_its_corners() {
        // A triangle through the middle of a cube, between corners of the cube.
        let mesh = lodc_fixtures::named("cube").expect("a shape");
        let at = |v: u32| glam::Vec3::from(mesh.positions()[v as usize]).as_dvec3();
        let tree =
            TriangleTree::new(&mesh.triangles().iter().map(|t| t.map(at)).collect::<Vec<_>>());
        let corner = |sign: DVec3| {
            let all = (0..mesh.vertex_count() as u32).map(at);
            all.max_by(|a, b| a.dot(sign).total_cmp(&b.dot(sign))).expect("corners")
        };
        let inner = [DVec3::ONE, DVec3::new(-1.0, -1.0, 1.0), DVec3::new(-1.0, 1.0, -1.0)];
        let inside = DistanceField::new(&[inner.map(corner)], &tree, mesh.diagonal() / 160.0);
        let side = mesh.diagonal() as f32 / 3.0f32.sqrt();
        let largest = inside.largest();
        assert!(largest > 0.15 * side && largest <= 0.5 * side, "{largest} of {side}");
    }
}
