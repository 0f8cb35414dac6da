//! Smooth normals for surfaces whose file has none, by one rule for all pictures and comparisons.
//!
//! An edge between two triangles, one on each side of it, is smooth unless their normals are more
//! than 60° apart. Around a position, all triangles that smooth edges connect share a normal: the
//! mean of theirs, weighted by their angles at the position (Thürmer and Wüthrich 1998). It does
//! not depend on how a face is cut into triangles.

use glam::{DVec3, Vec3};
use lodc_mesh::{Csr, DisjointSets, PositionIds};
use rayon::prelude::*;

/// Cosine of the angle between two triangles' normals beyond which their edge is sharp: 60°. Chosen
/// by hand.
const CREASE_COSINE: f64 = 0.5;
/// At an edge with many triangles each is compared only with this many of the following ones, so
/// that time does not grow with the square of their number. Chosen by hand.
const MAX_COMPARED: usize = 16;

/// Returns the normal of each triangle, of length one; zero for a triangle without area.
#[must_use]
pub fn flat_normals(triangles: &[[u32; 3]], positions: &[DVec3]) -> Vec<Vec3> {
    triangles.par_iter().map(|t| flat_normal(t, positions).as_vec3()).collect()
}

/// Returns a normal for every corner of every triangle, of length one; zero if a triangle has no
/// area and shares no normal with others. `ids` says which vertices are at one position.
///
/// # Panics
/// If a triangle names a vertex without a position.
#[must_use]
pub fn smooth_normals(
    triangles: &[[u32; 3]],
    positions: &[DVec3],
    ids: &PositionIds,
) -> Vec<[Vec3; 3]> {
    let stars = Stars {
        triangles,
        positions,
        ids,
        flat: triangles.par_iter().map(|t| flat_normal(t, positions)).collect(),
    };
    let faces: Vec<[u32; 3]> =
        triangles.par_iter().map(|t| t.map(|v| ids.of_vertex[v as usize])).collect();
    // The corners (3 × triangle + 0, 1 or 2) at each position.
    let around = Csr::corners(&faces, ids.first_vertex.len());
    let points = 0..around.rows() as u32;
    let corner_normals: Vec<Vec3> =
        points.into_par_iter().flat_map_iter(|p| stars.normals(around.row(p))).collect();
    let mut normals = vec![[Vec3::ZERO; 3]; triangles.len()];
    for (&corner, normal) in around.values.iter().zip(corner_normals) {
        normals[corner as usize / 3][corner as usize % 3] = normal;
    }
    normals
}

fn flat_normal(t: &[u32; 3], positions: &[DVec3]) -> DVec3 {
    let [a, b, c] = t.map(|v| positions[v as usize]);
    unit((b - a).cross(c - a))
}

/// Scales a vector to length one; zero, or one that is not finite, becomes zero.
fn unit(v: DVec3) -> DVec3 {
    // Scaled first, so that the squares of tiny vectors do not underflow.
    let size = v.abs().max_element();
    if size > 0.0 && size.is_finite() { (v / size).normalize() } else { DVec3::ZERO }
}

/// A surface, for the normals of the triangles around each of its positions.
struct Stars<'a> {
    triangles: &'a [[u32; 3]],
    positions: &'a [DVec3],
    ids: &'a PositionIds,
    /// The normal of each triangle.
    flat: Vec<DVec3>,
}

impl Stars<'_> {
    /// Returns the normals of the corners at one position.
    fn normals(&self, corners: &[u32]) -> Vec<Vec3> {
        // Two edges from the position for each corner: the position of the other end, the index of
        // the corner, and whether the triangle's outline runs outwards along the edge.
        let mut spokes: Vec<(u32, usize, bool)> = Vec::with_capacity(2 * corners.len());
        for (i, &corner) in corners.iter().enumerate() {
            let [_, b, c] = self.vertices_from(corner);
            let end = |v: u32| self.ids.of_vertex[v as usize];
            spokes.extend([(end(b), i, true), (end(c), i, false)]);
        }
        spokes.sort_unstable();
        // Corners that share a normal.
        let mut sets = DisjointSets::new(corners.len());
        for edge in spokes.chunk_by(|a, b| a.0 == b.0) {
            for (i, &(_, one, outward)) in edge.iter().enumerate() {
                for &(_, other, other_outward) in edge[i + 1..].iter().take(MAX_COMPARED) {
                    let [n, m] = [one, other].map(|k| self.flat[corners[k] as usize / 3]);
                    // Triangles that run the same way along the edge are not neighbours on one side
                    // of a surface: beyond a sharp edge, the back of a two-sided sheet may have
                    // nearly the normal of the front's neighbour.
                    if outward != other_outward && n.dot(m) > CREASE_COSINE {
                        sets.join(one as u32, other as u32);
                    }
                }
            }
        }
        let mut sums = vec![DVec3::ZERO; corners.len()];
        for (i, &corner) in corners.iter().enumerate() {
            sums[sets.find(i as u32) as usize] +=
                self.flat[corner as usize / 3] * self.angle(corner);
        }
        let normal = |(i, &corner): (usize, &u32)| {
            let mean = unit(sums[sets.find(i as u32) as usize]);
            let flat = self.flat[corner as usize / 3];
            (if mean == DVec3::ZERO { flat } else { mean }).as_vec3()
        };
        corners.iter().enumerate().map(normal).collect()
    }

    /// Returns the vertices of a triangle, beginning with that of a corner.
    fn vertices_from(&self, corner: u32) -> [u32; 3] {
        let t = self.triangles[corner as usize / 3];
        let k = corner as usize % 3;
        [t[k], t[(k + 1) % 3], t[(k + 2) % 3]]
    }

    /// Returns the angle of a triangle at a corner, in radians.
    fn angle(&self, corner: u32) -> f64 {
        let [a, b, c] = self.vertices_from(corner).map(|v| self.positions[v as usize]);
        arc_cosine(unit(b - a).dot(unit(c - a)).clamp(-1.0, 1.0))
    }
}

/// Returns the arc cosine with an error below 0.0001, by operations that every machine rounds alike
/// (Abramowitz and Stegun 1964, 4.4.45).
fn arc_cosine(x: f64) -> f64 {
    let positive = x.abs();
    let series = 1.570_728_8
        + positive * (-0.212_114_4 + positive * (0.074_261_0 + positive * -0.018_729_3));
    let angle = (1.0 - positive).sqrt() * series;
    if x < 0.0 { std::f64::consts::PI - angle } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn positions_and_normals(mesh: &lodc_mesh::Mesh) -> (Vec<DVec3>, Vec<[Vec3; 3]>) {
        let positions: Vec<DVec3> =
            mesh.positions().iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
        let ids = mesh.position_ids();
        let normals = smooth_normals(mesh.triangles(), &positions, &ids);
        (positions, normals)
    }

    #[test]
    fn a_cube_keeps_its_edges_and_a_sphere_is_round() {
        let cube = lodc_fixtures::named("cube").expect("a shape");
        let (positions, normals) = positions_and_normals(&cube);
        for (flat, corners) in flat_normals(cube.triangles(), &positions).iter().zip(&normals) {
            assert!(corners.iter().all(|n| n.dot(*flat) > 0.999_999), "{flat} {corners:?}");
        }
        let sphere = lodc_fixtures::named("icosphere").expect("a shape");
        let (positions, normals) = positions_and_normals(&sphere);
        for (t, corners) in sphere.triangles().iter().zip(&normals) {
            for (v, n) in t.iter().zip(corners) {
                assert!(positions[*v as usize].normalize().as_vec3().dot(*n) > 0.99);
            }
        }
    }

    #[test]
    fn cutting_a_face_finer_changes_no_normal() {
        // A roof of two squares, 40° between their normals; then one square in many slivers.
        let (sine, cosine) = 40.0f64.to_radians().sin_cos();
        let roof = |cuts: u32| {
            let mut positions = vec![[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
            positions.extend((0..=cuts).map(|i| {
                let y = f64::from(i) / f64::from(cuts);
                [cosine, y, -sine]
            }));
            let mut triangles = vec![[0, 1, 2]];
            triangles.extend((0..cuts).map(|i| [0, 3 + i, 4 + i]));
            triangles.push([0, 3 + cuts, 1]);
            let positions: Vec<DVec3> = positions.into_iter().map(DVec3::from).collect();
            let single: Vec<[f32; 3]> = positions.iter().map(|p| p.as_vec3().to_array()).collect();
            smooth_normals(&triangles, &positions, &PositionIds::new(&single))[0][0]
        };
        assert!(roof(1).abs_diff_eq(roof(50), 1e-3), "{} {}", roof(1), roof(50));
    }

    #[test]
    fn sheets_that_touch_back_to_back_keep_their_sides() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let single = positions.map(|p| p.as_vec3().to_array());
        let ids = PositionIds::new(&single);
        let normals = smooth_normals(&[[0, 1, 2], [0, 2, 1]], &positions, &ids);
        assert_eq!(normals, [[Vec3::Z; 3], [-Vec3::Z; 3]]);
    }

    #[test]
    fn the_back_of_a_sheet_changes_no_normal_of_its_front() {
        // Two faces that meet in a blade, 160° between their normals.
        let (sine, cosine) = 160.0f64.to_radians().sin_cos();
        let positions = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [cosine, 0.0, -sine]];
        let positions = positions.map(DVec3::from);
        let single = positions.map(|p| p.as_vec3().to_array());
        let ids = PositionIds::new(&single);
        let front = [[0, 1, 2], [1, 0, 3]];
        let normals = smooth_normals(&front, &positions, &ids);
        let two_sided: Vec<_> = front.into_iter().chain(front.map(|[a, b, c]| [a, c, b])).collect();
        assert_eq!(smooth_normals(&two_sided, &positions, &ids)[..2], normals);
    }

    #[test]
    fn the_arc_cosine_is_near() {
        for i in -100..=100 {
            let x = f64::from(i) / 100.0;
            assert!((arc_cosine(x) - x.acos()).abs() < 1e-4, "{x}");
        }
    }
}
