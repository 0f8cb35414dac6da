//! Orthographic cameras around a sphere: 20 for the metrics of `lodc-simplify` that judge collapses
//! by pictures, and others, spread evenly, to judge the result.

use glam::DVec3;

/// Steps per pixel to which points are snapped.
pub const SUBPIXELS: i32 = 256;
/// Steps of depth per pixel: finer than across, so that close layers keep their order. Chosen by
/// hand.
const DEPTH_STEPS: f64 = 1024.0;
/// The share of the picture's width that the sphere around the mesh fills: a margin of some pixels.
/// Chosen by hand.
const FILLED_SHARE: f64 = 0.95;
/// Pixels from the middle beyond which points are clamped, so that products of coordinates fit 64
/// bits.
const MAX_PIXELS_FROM_MIDDLE: f64 = 131_072.0;

/// The projection of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Point {
    /// In 256ths of a pixel, from the left edge.
    pub x: i32,
    /// In 256ths of a pixel, from the top edge.
    pub y: i32,
    /// In 1024ths of a pixel, away from the camera.
    pub z: i32,
}

/// An orthographic camera that looks at a sphere and takes square pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Unit vector from the middle towards the camera.
    pub toward: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to the top of the picture.
    pub up: DVec3,
    /// Point in the middle of the picture.
    pub center: DVec3,
    /// Pixels per unit of length, the same at every depth.
    pub scale: f64,
    /// Pixels across and down.
    pub size: u32,
}

impl Camera {
    /// A camera that sees the sphere of `radius` about `center` from the direction `toward` (a unit
    /// vector), filling 95 % of `size` pixels across.
    #[must_use]
    pub fn new(toward: DVec3, center: DVec3, radius: f64, size: u32) -> Self {
        // Any direction that is not nearly the one of sight (18°).
        let upward = if toward.y.abs() < 0.95 { DVec3::Y } else { DVec3::X };
        let right = upward.cross(toward).normalize();
        let up = toward.cross(right);
        let scale = if radius > 0.0 { FILLED_SHARE * 0.5 * f64::from(size) / radius } else { 1.0 };
        Self { toward, right, up, center, scale, size }
    }

    /// Steps of depth in a unit of length.
    #[must_use]
    pub fn depth_steps(&self) -> f64 {
        self.scale * DEPTH_STEPS
    }

    /// Projects a point and snaps it to the grid.
    #[must_use]
    pub fn project(&self, point: DVec3) -> Point {
        let p = (point - self.center) * self.scale;
        let half = 0.5 * f64::from(self.size);
        let snap = |pixels: f64, steps: f64| {
            let scaled =
                pixels.clamp(-MAX_PIXELS_FROM_MIDDLE, MAX_PIXELS_FROM_MIDDLE) * steps + 0.5;
            // `floor` by hand: truncating is one instruction, `floor` a call on some machines.
            let truncated = scaled as i32;
            truncated - i32::from(scaled < f64::from(truncated))
        };
        Point {
            x: snap(half + p.dot(self.right), f64::from(SUBPIXELS)),
            y: snap(half - p.dot(self.up), f64::from(SUBPIXELS)),
            z: snap(-p.dot(self.toward), DEPTH_STEPS),
        }
    }
}

/// The 20 cameras of metrics: at the corners of a dodecahedron (Castelló et al. 2007), rotated so
/// that none of them looks along an axis, a diagonal or a plane of symmetry that models are likely
/// to have.
#[must_use]
pub fn metric_cameras(center: DVec3, radius: f64, size: u32) -> Vec<Camera> {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let (long, short) = (golden, 1.0 / golden);
    let mut corners = Vec::with_capacity(20);
    for [a, b] in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
        corners.push(DVec3::new(-1.0, a, b));
        corners.push(DVec3::new(1.0, a, b));
        corners.push(DVec3::new(0.0, a * short, b * long));
        corners.push(DVec3::new(a * short, b * long, 0.0));
        corners.push(DVec3::new(b * long, 0.0, a * short));
    }
    corners.into_iter().map(|c| Camera::new(turned(c).normalize(), center, radius, size)).collect()
}

/// Turns a vector by a fixed rotation without any symmetry: two Householder mirrors in arbitrary
/// planes.
fn turned(v: DVec3) -> DVec3 {
    let mirrored =
        |v: DVec3, across: DVec3| v - across * (2.0 * v.dot(across) / across.length_squared());
    mirrored(mirrored(v, DVec3::new(0.31, 0.83, 0.47)), DVec3::new(0.72, 0.19, 0.65))
}

/// `count` cameras spread evenly over the sphere (a Fibonacci lattice), none of them one of
/// [`metric_cameras`].
#[must_use]
pub fn spread_cameras(count: u32, center: DVec3, radius: f64, size: u32) -> Vec<Camera> {
    // Cosine and sine of π (1 + √5), by which each point is turned against the one before: as
    // numbers, since sines of libraries differ between machines.
    let (cos, sin) = (-0.737_368_878_078_320_3, -0.675_490_294_261_523_2);
    // The first point is turned by half of that.
    let (mut x, mut y) = (0.362_374_890_080_479_8, -0.932_032_423_813_227_7);
    (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let r = (1.0 - z * z).max(0.0).sqrt();
            let toward = DVec3::new(r * x, r * y, z);
            (x, y) = (x * cos - y * sin, x * sin + y * cos);
            Camera::new(toward.normalize(), center, radius, size)
        })
        .collect()
}
