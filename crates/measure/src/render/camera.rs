//! The camera of a picture: from a direction, at the distance at which everything just fits, or
//! from a viewpoint.

use super::angles::{sin_cos, tan_of_half};
use glam::{DVec3, Vec3};

/// The axis that points up in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// The second axis, as in glTF; the front of things looks along the third.
    #[default]
    Y,
    /// The third axis, as in many CAD files; the front of things looks against the second.
    Z,
}

/// Projection of the scene's depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// With this angle between the upper and the lower edge, in degrees, above 0 and below 180.
    Perspective(f64),
    /// Without perspective.
    Orthographic,
}

/// The side that a picture shows, and how much of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framing {
    /// The upward axis.
    pub up: Up,
    /// Degrees around the upward axis: 0 sees the front, 90 the thing's left side (its `+x` for
    /// `Up::Y`).
    pub azimuth: f64,
    /// Degrees above the horizon, -90 to 90.
    pub elevation: f64,
    /// The lens.
    pub lens: Lens,
    /// Zoom: 1 just fits.
    pub zoom: f64,
}

/// An eye, and where it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// The position of the eye.
    pub eye: [f64; 3],
    /// The point in the middle of the picture.
    pub target: [f64; 3],
    /// The upward axis.
    pub up: Up,
    /// Degrees between the upper and the lower edge, above 0 and below 180.
    pub degrees: f64,
    /// Zoom: 1 shows these degrees.
    pub zoom: f64,
}

impl Viewpoint {
    /// Right, up, towards the camera. A view along the upward axis takes `ahead` as up instead; a
    /// view of nowhere looks down.
    fn axes(&self) -> [[f64; 3]; 3] {
        let (up, ahead) = match self.up {
            Up::Y => ([0.0, 1.0, 0.0], [0.0, 0.0, -1.0]),
            Up::Z => ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
        };
        let toward: [f64; 3] = std::array::from_fn(|i| self.eye[i] - self.target[i]);
        let toward = normalised(toward).unwrap_or(up);
        // None where the view is along `up`, as nearly as doubles can tell.
        let right_of =
            |up| normalised(cross(up, toward)).filter(|_| dot(up, toward).abs() < 1.0 - 1e-9);
        let right = right_of(up).or_else(|| right_of(ahead)).unwrap_or([1.0, 0.0, 0.0]);
        [right, cross(toward, right), toward]
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn normalised(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|c| c / length))
}

/// A camera in the space of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Origin of corners, in the space of the scene.
    pub centre: [f64; 3],
    /// Right, up, and towards the camera.
    axes: [[f64; 3]; 3],
    up: Up,
    /// The camera, relative to the centre, along its axes.
    eye: [f64; 3],
    /// Half the extent of the picture across and down, at distance 1 from the eye or, without
    /// perspective, anywhere.
    half: [f64; 2],
    perspective: bool,
    /// Distances from the eye between which everything lies.
    depth: [f64; 2],
}

/// Share of a picture's width or height that stays free at each side. Chosen by hand.
const MARGIN: f64 = 0.04;
/// Share of the width or height between the margins.
const FILLED: f64 = 1.0 - 2.0 * MARGIN;

/// Least distance of an eye from the nearest point, as a share of the size of what is seen: so that
/// no point lies at the eye. Chosen by hand, as the shares of the size below.
const MIN_GAP: f64 = 0.01;
/// Share of the size by which the seen depths exceed those of the points at both ends, so that
/// rounding cuts nothing off.
const DEPTH_MARGIN: f64 = 1e-3;
/// Least near distance as a share of the size. The larger, the finer are depths; the smaller, the
/// less is cut off.
const MIN_NEAR: f64 = 1e-4;
/// The same for an eye at a viewpoint, which may be amid the points.
const MIN_NEAR_AT_VIEWPOINT: f64 = 1e-3;

/// Lowest and highest value of something over points.
type Bounds = (f64, f64);

/// Points as a camera's axes see them, relative to the middle of their box.
struct PointsInView<'a> {
    points: &'a [[f64; 3]],
    centre: [f64; 3],
    axes: [[f64; 3]; 3],
}

impl<'a> PointsInView<'a> {
    fn new(points: &'a [[f64; 3]], axes: [[f64; 3]; 3]) -> Self {
        Self { points, centre: Camera::middle(points), axes }
    }

    /// Bounds along an axis, each point moved by its depth times `slope`.
    fn sheared(&self, axis: usize, slope: f64) -> Bounds {
        let along = |p: &[f64; 3], axis: usize| -> f64 {
            (0..3).map(|i| (p[i] - self.centre[i]) * self.axes[axis][i]).sum()
        };
        bounds(self.points.iter().map(|p| along(p, axis) + slope * along(p, 2)))
    }

    /// Bounds along an axis.
    fn along(&self, axis: usize) -> Bounds {
        self.sheared(axis, 0.0)
    }

    /// The farthest and the nearest value along the axis of view; zeros where there are no points.
    /// The axis points towards the camera, so the lowest is farthest.
    fn depth_range(&self) -> Bounds {
        let (farthest, nearest) = self.along(2);
        if farthest <= nearest { (farthest, nearest) } else { (0.0, 0.0) }
    }

    /// The largest extent along an axis; 1 where there is none.
    fn size(&self) -> f64 {
        let size = (0..3).map(|a| self.along(a)).map(|(l, h)| h - l).fold(0.0, f64::max);
        if size > 0.0 && size.is_finite() { size } else { 1.0 }
    }
}

fn bounds(values: impl Iterator<Item = f64>) -> Bounds {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
}

impl Camera {
    /// The camera at which all points just fit into a picture of this width divided by height.
    #[must_use]
    pub fn around(points: &[[f64; 3]], framing: &Framing, aspect: f64) -> Self {
        let axes = axes(framing);
        let in_view = PointsInView::new(points, axes);
        let size = in_view.size();
        let (farthest, nearest) = in_view.depth_range();
        let (eye, half) = match framing.lens {
            Lens::Perspective(degrees) => {
                let tangent = tan_of_half(degrees);
                let half = [tangent * aspect, tangent];
                let mut eye = perspective_eye(&in_view, half);
                eye[2] = eye[2].max(nearest + size * MIN_GAP);
                // Zoom narrows the view; the eye stays where it is.
                (eye, half.map(|h| h / framing.zoom))
            }
            Lens::Orthographic => {
                let (mut eye, half) = orthographic_eye(&in_view, aspect);
                eye[2] = nearest + size;
                let half = if half > 0.0 { half } else { size } / framing.zoom;
                (eye, [half * aspect, half])
            }
        };
        Self {
            centre: in_view.centre,
            axes,
            up: framing.up,
            eye,
            half,
            perspective: matches!(framing.lens, Lens::Perspective(_)),
            depth: [
                (eye[2] - nearest - size * DEPTH_MARGIN).max(size * MIN_NEAR),
                eye[2] - farthest + size * DEPTH_MARGIN,
            ],
        }
    }

    /// Returns the middle of the box around points.
    #[must_use]
    pub fn middle(points: &[[f64; 3]]) -> [f64; 3] {
        std::array::from_fn(|i| {
            let (low, high) = bounds(points.iter().map(|p| p[i]));
            if low <= high { low / 2.0 + high / 2.0 } else { 0.0 }
        })
    }

    /// The camera of a viewpoint: at a position, towards a point, with a vertical field of view in
    /// degrees. What is behind it is not seen.
    #[must_use]
    pub fn at(points: &[[f64; 3]], view: &Viewpoint, aspect: f64) -> Self {
        let in_view = PointsInView::new(points, view.axes());
        let from_centre: [f64; 3] = std::array::from_fn(|i| view.eye[i] - in_view.centre[i]);
        let eye = in_view.axes.map(|axis| dot(axis, from_centre));
        let tangent = tan_of_half(view.degrees) / view.zoom;
        let size = in_view.size();
        let (farthest, nearest) = in_view.depth_range();
        let near = (eye[2] - nearest - size * DEPTH_MARGIN).max(size * MIN_NEAR_AT_VIEWPOINT);
        let far = (eye[2] - farthest + size * DEPTH_MARGIN).max(near + size * DEPTH_MARGIN);
        Self {
            centre: in_view.centre,
            axes: in_view.axes,
            up: view.up,
            eye,
            half: [tangent * aspect, tangent],
            perspective: true,
            depth: [near, far],
        }
    }

    /// From positions relative to the centre to a graphics device's clip space, column by column.
    /// Depth grows from 0 to 1.
    #[must_use]
    pub fn matrix(&self) -> [[f32; 4]; 4] {
        let [near, far] = self.depth;
        let shift: [f64; 3] = std::array::from_fn(|a| -self.eye[a]);
        // Rows of the view: the camera looks along its negative third axis.
        let row = |a: usize| [self.axes[a][0], self.axes[a][1], self.axes[a][2], shift[a]];
        let scaled = |row: [f64; 4], s: f64| row.map(|v| v * s);
        let toward = row(2);
        let plus = |mut r: [f64; 4], w: f64| {
            r[3] += w;
            r
        };
        let across = scaled(row(0), 1.0 / self.half[0]);
        let upward = scaled(row(1), 1.0 / self.half[1]);
        let rows = if self.perspective {
            let k = far / (far - near);
            [across, upward, plus(scaled(toward, -k), -k * near), scaled(toward, -1.0)]
        } else {
            let k = 1.0 / (far - near);
            [across, upward, plus(scaled(toward, -k), -k * near), [0.0, 0.0, 0.0, 1.0]]
        };
        std::array::from_fn(|column| std::array::from_fn(|r| rows[r][column] as f32))
    }

    /// Returns a point, relative to the centre, as the camera sees it: across and up, each -1 to 1
    /// in the picture once it is divided by the third, then that divisor (the distance or, without
    /// perspective, 1), then the distance from the eye along the axis of view.
    pub(super) fn seen(&self, p: [f32; 3]) -> [f64; 4] {
        let p = p.map(f64::from);
        let [x, y, z] = std::array::from_fn(|a| dot(self.axes[a], p) - self.eye[a]);
        [x / self.half[0], y / self.half[1], if self.perspective { -z } else { 1.0 }, -z]
    }

    /// The nearest distance from the eye that is seen; none without perspective.
    pub(super) fn near(&self) -> Option<f64> {
        self.perspective.then_some(self.depth[0])
    }

    /// Returns the depth at a distance from the eye, 0 to 1; it changes evenly over the picture of
    /// a plane.
    pub(super) fn depth(&self, distance: f64) -> f64 {
        let [near, far] = self.depth;
        let depth = if self.perspective {
            far / (far - near) * (1.0 - near / distance)
        } else {
            (distance - near) / (far - near)
        };
        depth.clamp(0.0, 1.0)
    }

    /// Right, up and towards the camera, in the space of the scene.
    pub(super) fn axes(&self) -> [Vec3; 3] {
        self.axes.map(|axis| DVec3::from(axis).as_vec3())
    }

    /// Direction of the sky.
    pub(super) fn world_up(&self) -> Vec3 {
        match self.up {
            Up::Y => Vec3::Y,
            Up::Z => Vec3::Z,
        }
    }

    /// The eye relative to the centre, in the space of the scene; none without perspective.
    pub(super) fn eye(&self) -> Option<Vec3> {
        let along = |i: usize| (0..3).map(|a| self.axes[a][i] * self.eye[a]).sum::<f64>() as f32;
        self.perspective.then(|| Vec3::new(along(0), along(1), along(2)))
    }

    /// Returns the distance along the axis of view of a point relative to the centre, for sorting.
    #[must_use]
    pub fn distance(&self, p: [f32; 3]) -> f32 {
        let toward = self.axes[2];
        (self.eye[2] - (0..3).map(|i| toward[i] * f64::from(p[i])).sum::<f64>()) as f32
    }
}

/// The nearest eye from which all points lie within these slopes of the axis of view, but for the
/// margin.
///
/// Of points at one depth, those at the edges of the picture decide; the distance follows from both
/// sides together, the eye's position across from their difference.
fn perspective_eye(in_view: &PointsInView<'_>, half: [f64; 2]) -> [f64; 3] {
    let mut eye = [0.0; 3];
    let mut distance = f64::NEG_INFINITY;
    for a in 0..2 {
        let slope = half[a] * FILLED;
        let (_, high) = in_view.sheared(a, slope);
        let (low, _) = in_view.sheared(a, -slope);
        if low.is_finite() && high.is_finite() {
            eye[a] = high / 2.0 + low / 2.0;
            distance = distance.max((high - low) / (2.0 * slope));
        }
    }
    eye[2] = if distance.is_finite() { distance } else { 0.0 };
    eye
}

/// The eye in front of the middle of all points, and half the height of a picture of this aspect
/// that holds them; 0 where there are none.
fn orthographic_eye(in_view: &PointsInView<'_>, aspect: f64) -> ([f64; 3], f64) {
    let mut eye = [0.0; 3];
    let mut half: f64 = 0.0;
    for (a, shape) in [aspect, 1.0].into_iter().enumerate() {
        let (low, high) = in_view.along(a);
        if low <= high {
            eye[a] = low / 2.0 + high / 2.0;
            half = half.max((high - low) / (2.0 * shape * FILLED));
        }
    }
    (eye, half)
}

/// Right, up, towards the camera.
fn axes(framing: &Framing) -> [[f64; 3]; 3] {
    let (sa, ca) = sin_cos(framing.azimuth);
    let (se, ce) = sin_cos(framing.elevation.clamp(-90.0, 90.0));
    let rotated = [[ca, 0.0, -sa], [-sa * se, ce, -ca * se], [sa * ce, se, ca * ce]];
    match framing.up {
        Up::Y => rotated,
        Up::Z => rotated.map(|[x, y, z]| [x, -z, y]),
    }
}

#[cfg(test)]
#[path = "camera_tests.rs"]
mod tests;
