//! Vectors four at a time, and values between corners.

use glam::{Vec3, Vec4};

/// Four vectors.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Vec3x4 {
    x: Vec4,
    y: Vec4,
    z: Vec4,
}

impl Vec3x4 {
    #[inline]
    pub(super) fn new([a, b, c, d]: &[Vec3; 4]) -> Self {
        Self {
            x: Vec4::new(a.x, b.x, c.x, d.x),
            y: Vec4::new(a.y, b.y, c.y, d.y),
            z: Vec4::new(a.z, b.z, c.z, d.z),
        }
    }

    /// One vector times a factor in every lane, plus a second and a third.
    #[inline]
    pub(super) fn mix([a, b, c]: [Vec3; 3], [u, v, w]: [Vec4; 3]) -> Self {
        Self {
            x: a.x * u + b.x * v + c.x * w,
            y: a.y * u + b.y * v + c.y * w,
            z: a.z * u + b.z * v + c.z * w,
        }
    }

    /// The dot products lane by lane.
    #[inline]
    pub(super) fn dot(self, other: Self) -> Vec4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The dot products with one vector.
    #[inline]
    pub(super) fn dot_with(self, v: Vec3) -> Vec4 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// The differences from one vector.
    #[inline]
    pub(super) fn minus(self, v: Vec3) -> Self {
        Self { x: self.x - v.x, y: self.y - v.y, z: self.z - v.z }
    }

    /// The differences lane by lane.
    #[inline]
    pub(super) fn minus_each(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    /// The differences from `a u + b v`, with factors for each lane.
    #[inline]
    pub(super) fn minus_span(self, [a, b]: [Vec3; 2], [u, v]: [Vec4; 2]) -> Self {
        Self {
            x: self.x - (u * a.x + v * b.x),
            y: self.y - (u * a.y + v * b.y),
            z: self.z - (u * a.z + v * b.z),
        }
    }
}

/// Points in moved faces, one for each of four samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearestPoints {
    /// The indices of the moved faces.
    pub(super) face: [u32; 4],
    /// Shares of the second and third corner.
    pub(super) at: [Vec4; 2],
    /// From the point to the sample.
    pub(super) away: Vec3x4,
    /// The squared length of that.
    pub(super) squared: Vec4,
}

/// The cosines between the normals `shown`, of any length, and unit normals; one half where `shown`
/// is zero.
#[inline]
pub(super) fn cosines(shown: Vec3x4, normal: Vec3x4) -> Vec4 {
    let squared = shown.dot(shown);
    let length = squared.sqrt();
    let none = length.cmple(Vec4::ZERO);
    let divisor = Vec4::select(none, Vec4::ONE, length);
    Vec4::select(none, Vec4::splat(0.5), shown.dot(normal) / divisor)
}

/// The value at shares of the second and third corner.
pub(super) fn mix(corners: &[Vec3; 3], [u, v]: [f32; 2]) -> Vec3 {
    corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v
}

/// Texture coordinates at shares of the second and third corner.
pub(super) fn mix_coordinates(corners: &[[f32; 2]; 3], [u, v]: [f32; 2]) -> [f32; 2] {
    [0, 1].map(|k| corners[0][k] * (1.0 - u - v) + corners[1][k] * u + corners[2][k] * v)
}
