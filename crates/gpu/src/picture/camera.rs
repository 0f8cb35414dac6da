//! Camera of a picture: a direction, and the distance at which everything just fits.

/// The direction that a picture calls up.
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

/// Share of a picture's width or height that stays free at each side.
const MARGIN: f64 = 0.04;

impl Camera {
    /// The camera at which all points just fit into a picture of this width divided by height.
    #[must_use]
    pub fn around(points: &[[f64; 3]], framing: &Framing, aspect: f64) -> Self {
        let axes = axes(framing);
        let bounds = |of: &dyn Fn(&[f64; 3]) -> f64| {
            points
                .iter()
                .map(of)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
        };
        let middle: [f64; 3] = std::array::from_fn(|i| {
            let (low, high) = bounds(&|p| p[i]);
            if low <= high { low / 2.0 + high / 2.0 } else { 0.0 }
        });
        let along = |p: &[f64; 3], axis: usize| -> f64 {
            (0..3).map(|i| (p[i] - middle[i]) * axes[axis][i]).sum()
        };
        let (near, far) = bounds(&|p| along(p, 2));
        let size = (0..3).map(|a| bounds(&|p| along(p, a))).map(|(l, h)| h - l).fold(0.0, f64::max);
        let size = if size > 0.0 && size.is_finite() { size } else { 1.0 };
        let (near, far) = if near <= far { (near, far) } else { (0.0, 0.0) };
        let free = 1.0 - 2.0 * MARGIN;
        let mut camera = Self {
            centre: middle,
            axes,
            up: framing.up,
            eye: [0.0; 3],
            half: [0.0; 2],
            perspective: true,
            depth: [0.0; 2],
        };
        match framing.lens {
            Lens::Perspective(degrees) => {
                let tangent = (degrees.to_radians() / 2.0).tan();
                camera.half = [tangent * aspect, tangent];
                // Of points at one depth, those at the edges of the picture decide; the distance
                // follows from both sides together, the eye's place across from their difference.
                let mut distance = f64::NEG_INFINITY;
                for a in 0..2 {
                    let t = camera.half[a] * free;
                    let (_, high) = bounds(&|p| along(p, a) + t * along(p, 2));
                    let (low, _) = bounds(&|p| along(p, a) - t * along(p, 2));
                    if low.is_finite() && high.is_finite() {
                        camera.eye[a] = high / 2.0 + low / 2.0;
                        distance = distance.max((high - low) / (2.0 * t));
                    }
                }
                let distance =
                    if distance.is_finite() { distance } else { 0.0 }.max(far + size * 0.01);
                // Nearer makes larger; what lies in front of the eye's new place is cut off.
                camera.eye[2] = distance;
                camera.half = camera.half.map(|h| h / framing.zoom);
            }
            Lens::Orthographic => {
                camera.perspective = false;
                let mut scale: f64 = 0.0;
                for (a, shape) in [aspect, 1.0].into_iter().enumerate() {
                    let (low, high) = bounds(&|p| along(p, a));
                    if low <= high {
                        camera.eye[a] = low / 2.0 + high / 2.0;
                        scale = scale.max((high - low) / (2.0 * shape * free));
                    }
                }
                let scale = if scale > 0.0 { scale } else { size } / framing.zoom;
                camera.half = [scale * aspect, scale];
                camera.eye[2] = far + size;
            }
        }
        let eye = camera.eye[2];
        camera.depth = [(eye - far - size * 1e-3).max(size * 1e-4), eye - near + size * 1e-3];
        camera
    }

    /// From positions relative to the centre to the device's clip space, column by column. Depth
    /// grows from 0 to 1.
    pub(super) fn matrix(&self) -> [[f32; 4]; 4] {
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
        let down = scaled(row(1), 1.0 / self.half[1]);
        let rows = if self.perspective {
            let k = far / (far - near);
            [across, down, plus(scaled(toward, -k), -k * near), scaled(toward, -1.0)]
        } else {
            let k = 1.0 / (far - near);
            [across, down, plus(scaled(toward, -k), -k * near), [0.0, 0.0, 0.0, 1.0]]
        };
        std::array::from_fn(|column| std::array::from_fn(|r| rows[r][column] as f32))
    }

    /// Right, up and towards the camera, in the space of the scene.
    pub(super) fn axes(&self) -> [[f32; 3]; 3] {
        self.axes.map(|axis| axis.map(|v| v as f32))
    }

    /// Direction of the sky.
    pub(super) fn world_up(&self) -> [f32; 3] {
        match self.up {
            Up::Y => [0.0, 1.0, 0.0],
            Up::Z => [0.0, 0.0, 1.0],
        }
    }

    /// The eye relative to the centre, in the space of the scene.
    pub(super) fn eye(&self) -> [f32; 3] {
        std::array::from_fn(|i| (0..3).map(|a| self.axes[a][i] * self.eye[a]).sum::<f64>() as f32)
    }

    /// True if it has perspective.
    pub(super) fn has_perspective(&self) -> bool {
        self.perspective
    }

    /// Returns the depth of a point relative to the centre, for sorting.
    #[must_use]
    pub fn distance(&self, p: [f32; 3]) -> f32 {
        let toward = self.axes[2];
        (self.eye[2] - (0..3).map(|i| toward[i] * f64::from(p[i])).sum::<f64>()) as f32
    }
}

/// Right, up, towards the camera.
fn axes(framing: &Framing) -> [[f64; 3]; 3] {
    let (sa, ca) = framing.azimuth.to_radians().sin_cos();
    let (se, ce) = framing.elevation.clamp(-90.0, 90.0).to_radians().sin_cos();
    let turned = [[ca, 0.0, -sa], [-sa * se, ce, -ca * se], [sa * ce, se, ca * ce]];
    match framing.up {
        Up::Y => turned,
        Up::Z => turned.map(|[x, y, z]| [x, -z, y]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(camera: &Camera, p: [f64; 3]) -> [f64; 3] {
        let m = camera.matrix();
        let p: [f64; 3] = std::array::from_fn(|i| p[i] - camera.centre[i]);
        let at =
            |r: usize| (0..3).map(|c| f64::from(m[c][r]) * p[c]).sum::<f64>() + f64::from(m[3][r]);
        [at(0) / at(3), at(1) / at(3), at(2) / at(3)]
    }

    fn every(check: impl Fn(&Framing)) {
        for lens in [Lens::Perspective(30.0), Lens::Perspective(90.0), Lens::Orthographic] {
            for up in [Up::Y, Up::Z] {
                for (azimuth, elevation) in
                    [(0.0, 0.0), (35.0, 20.0), (200.0, -70.0), (0.0, 90.0), (90.0, -90.0)]
                {
                    check(&Framing { up, azimuth, elevation, lens, zoom: 1.0 });
                }
            }
        }
    }

    #[test]
    fn everything_fits_and_touches_the_margin() {
        let points: Vec<[f64; 3]> = (0..8)
            .map(|i| {
                [
                    f64::from(i & 1) * 7.0 + 100.0,
                    f64::from(i >> 1 & 1) * 2.0,
                    f64::from(i >> 2) * 3.0,
                ]
            })
            .collect();
        every(|framing| {
            for aspect in [0.5, 1.0, 2.5] {
                let camera = Camera::around(&points, framing, aspect);
                let edge =
                    points.iter().map(|&p| seen(&camera, p)).fold(0.0f64, |edge, [x, y, z]| {
                        assert!((0.0..=1.0).contains(&z), "{framing:?}: depth {z}");
                        edge.max(x.abs()).max(y.abs())
                    });
                assert!(
                    (edge - (1.0 - 2.0 * MARGIN)).abs() < 1e-4,
                    "{framing:?}, {aspect}: {edge}"
                );
            }
        });
    }

    #[test]
    fn nearer_points_have_less_depth_and_up_is_up() {
        let points = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]];
        let framing = Framing {
            up: Up::Y,
            azimuth: 0.0,
            elevation: 0.0,
            lens: Lens::Perspective(40.0),
            zoom: 1.0,
        };
        let camera = Camera::around(&points, &framing, 1.0);
        assert!(seen(&camera, [0.0, 0.0, 1.0])[2] < seen(&camera, [0.0, 0.0, 0.0])[2]);
        assert!(seen(&camera, [1.0, 0.0, 0.0])[0] > 0.0 && seen(&camera, [0.0, 1.0, 0.0])[1] > 0.0);
        // From the side of +x, the front is to the left.
        let side = Camera::around(&points, &Framing { azimuth: 90.0, ..framing }, 1.0);
        assert!(seen(&side, [0.0, 0.0, 1.0])[0] < 0.0);
        let cad = Camera::around(&points, &Framing { up: Up::Z, ..framing }, 1.0);
        assert!(
            seen(&cad, [0.0, 0.0, 1.0])[1] > 0.0
                && seen(&cad, [0.0, 0.0, 0.0])[2] < seen(&cad, [0.0, 1.0, 0.0])[2]
        );
    }

    #[test]
    fn nothing_and_a_point_have_a_camera_too() {
        every(|framing| {
            for points in [&[][..], &[[3.0, 4.0, 5.0]]] {
                let camera = Camera::around(points, framing, 1.5);
                assert!(
                    camera.matrix().as_flattened().iter().all(|v| v.is_finite()),
                    "{framing:?}"
                );
            }
        });
    }
}
