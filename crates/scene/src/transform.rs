//! Affine transforms of nodes, the largest stretch of one, and transformed normals.

use glam::{DAffine3, DMat3, DVec3};

/// An affine transform in double precision.
pub type Transform = DAffine3;

/// A node's transform relative to its parent (glTF 2.0, 3.5.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalTransform {
    /// As a matrix.
    Matrix(Transform),
    /// Scaled, then rotated, then translated. An animation changes one of the three.
    Trs {
        /// Translation.
        translation: [f64; 3],
        /// Rotation as a quaternion x, y, z, w of any length; zero stands for the identity.
        rotation: [f64; 4],
        /// Scale along the axes.
        scale: [f64; 3],
    },
}

impl Default for LocalTransform {
    fn default() -> Self {
        Self::Matrix(Transform::IDENTITY)
    }
}

impl LocalTransform {
    /// A matrix of sixteen numbers, column by column. The last row is taken to be 0, 0, 0, 1.
    #[must_use]
    pub fn from_columns(m: &[f64; 16]) -> Self {
        Self::Matrix(transform_from_columns(m))
    }

    /// Returns the transform as a matrix.
    #[must_use]
    pub fn matrix(&self) -> Transform {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Trs { translation, rotation, scale } => {
                let mut matrix3 = from_quaternion(rotation);
                for (axis, s) in scale.into_iter().enumerate() {
                    *matrix3.col_mut(axis) *= s;
                }
                Transform { matrix3, translation: translation.into() }
            }
        }
    }
}

/// A transform from sixteen numbers, column by column, without the last row.
#[must_use]
pub fn transform_from_columns(m: &[f64; 16]) -> Transform {
    let column = |c: usize| DVec3::new(m[4 * c], m[4 * c + 1], m[4 * c + 2]);
    Transform { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// Returns the rotation of a quaternion of any length; the identity for zero.
fn from_quaternion([x, y, z, w]: [f64; 4]) -> DMat3 {
    let n = x * x + y * y + z * z + w * w;
    if n == 0.0 || !n.is_finite() {
        return DMat3::IDENTITY;
    }
    let s = 2.0 / n;
    DMat3::from_cols_array_2d(&[
        [1.0 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)],
        [s * (x * y - z * w), 1.0 - s * (x * x + z * z), s * (y * z + x * w)],
        [s * (x * z + y * w), s * (y * z - x * w), 1.0 - s * (x * x + y * y)],
    ])
}

/// Returns the largest factor by which a matrix stretches a vector: its largest singular value, the
/// root of the largest eigenvalue of its Gram matrix, found by Jacobi rotations.
#[must_use]
pub fn largest_stretch(m: &DMat3) -> f64 {
    let columns = m.to_cols_array_2d();
    let size = columns.iter().flatten().fold(0.0f64, |s, v| s.max(v.abs()));
    if size == 0.0 || !size.is_finite() {
        return size;
    }
    // Scaled, so that squares neither vanish nor overflow.
    let axes = columns.map(|c| DVec3::from(c.map(|v| v / size)));
    let mut gram: [[f64; 3]; 3] = axes.map(|a| axes.map(|b| a.dot(b)));
    // Sweeps of three rotations: a few reach double precision; 16 is chosen by hand, to be safe.
    let trace = gram[0][0] + gram[1][1] + gram[2][2];
    let negligible = f64::EPSILON * f64::EPSILON * trace;
    for _ in 0..16 {
        if gram[0][1].abs().max(gram[0][2].abs()).max(gram[1][2].abs()) <= negligible {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate_to_zero(&mut gram, p, q);
        }
    }
    size * gram[0][0].max(gram[1][1]).max(gram[2][2]).max(0.0).sqrt()
}

/// Makes the entry (p, q) off the diagonal of a symmetric matrix zero, by a Jacobi rotation.
fn rotate_to_zero(g: &mut [[f64; 3]; 3], p: usize, q: usize) {
    if g[p][q] == 0.0 {
        return;
    }
    let theta = (g[q][q] - g[p][p]) / (2.0 * g[p][q]);
    let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
    let c = 1.0 / (t * t + 1.0).sqrt();
    let s = t * c;
    for row in &mut *g {
        let (a, b) = (row[p], row[q]);
        (row[p], row[q]) = (c * a - s * b, s * a + c * b);
    }
    let (a, b) = (g[p], g[q]);
    g[p] = std::array::from_fn(|k| c * a[k] - s * b[k]);
    g[q] = std::array::from_fn(|k| s * a[k] + c * b[k]);
}

/// Transforms a normal by the inverse transpose of a matrix, up to its length. Keeps the side that
/// the normal is on where the matrix mirrors.
#[must_use]
pub fn transform_normal(m: &DMat3, normal: DVec3) -> DVec3 {
    // Cofactors are the inverse transpose times the determinant. So there is no division; only the
    // sign of the determinant must be corrected.
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    let transformed = sign * (cofactors * normal);
    let size = transformed.abs().max_element();
    if size > 0.0 && size.is_finite() { transformed / size } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_stretch_is_the_largest_singular_value() {
        let turned = LocalTransform::Trs {
            translation: [9.0; 3],
            rotation: [0.5; 4],
            scale: [2.0, -7.0, 3.0],
        };
        assert!((largest_stretch(&turned.matrix().matrix3) - 7.0).abs() < 1e-12);
        // A shear stretches more than its longest column: the golden ratio.
        let shear = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        assert!((largest_stretch(&shear) - (1.0 + 5.0f64.sqrt()) / 2.0).abs() < 1e-12);
        assert_eq!(largest_stretch(&DMat3::ZERO), 0.0);
        let huge = largest_stretch(&(DMat3::IDENTITY * 1e200));
        assert!((huge / 1e200 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn quaternions_of_any_length_rotate_alike() {
        let matrix = |rotation| {
            LocalTransform::Trs { translation: [0.0; 3], rotation, scale: [1.0; 3] }.matrix()
        };
        let quarter = matrix([0.0, 0.0, 1.0, 1.0]);
        assert!(quarter.abs_diff_eq(matrix([0.0, 0.0, 7.0, 7.0]), 1e-12));
        let x = quarter.transform_point3(DVec3::X);
        assert!(x.abs_diff_eq(DVec3::Y, 1e-12), "{x}");
        assert_eq!(matrix([0.0; 4]), Transform::IDENTITY);
    }

    #[test]
    fn normals_stay_upright_under_any_scale() {
        // A plane x + y = 0 stretched along x: its normal turns towards y.
        let m = DMat3::from_diagonal(DVec3::new(4.0, 1.0, 1.0));
        let n = transform_normal(&m, DVec3::new(1.0, 1.0, 0.0));
        assert!(n.dot(m * DVec3::new(1.0, -1.0, 0.0)).abs() < 1e-12 && n.x > 0.0);
        let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        assert_eq!(transform_normal(&mirror, DVec3::X), -DVec3::X);
    }
}
