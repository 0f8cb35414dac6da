//! From corners to points of the picture: what is in front of the eye, and not too far beside the
//! picture, in the rasteriser's integers.

use super::{Camera, Corner};
use lodc_raster::{Point, SUBPIXELS};

/// Pixels beside the picture at which triangles are cut, so that the rasteriser's products fit 64
/// bits. Chosen by hand.
const MARGIN: f64 = 65_536.0;
/// Steps of depth from the nearest to the farthest.
const DEPTH_STEPS: f64 = (1 << 30) as f64;

/// A camera and the pixels of its picture.
pub(super) struct Projection<'a> {
    pub(super) camera: &'a Camera,
    /// Pixels, across and down.
    size: [f64; 2],
}

/// A corner as the picture has it: columns and rows from the upper left corner, once they are
/// divided by the third, that divisor, and the distance from the eye.
type Seen = [f64; 4];

impl<'a> Projection<'a> {
    pub(super) fn new(camera: &'a Camera, size: [u32; 2]) -> Self {
        Self { camera, size: size.map(f64::from) }
    }

    /// Returns a corner as the picture has it.
    pub(super) fn seen(&self, corner: &Corner) -> Seen {
        let [x, y, w, distance] = self.camera.seen(corner.position);
        [0.5 * self.size[0] * (w + x), 0.5 * self.size[1] * (w - y), w, distance]
    }

    /// Calls `piece` with triangles that together are the visible part of one; two that share an
    /// edge have the same points along it.
    pub(super) fn pieces(&self, triangle: &[Corner; 3], mut piece: impl FnMut([Point; 3])) {
        let corners = triangle.each_ref().map(|c| self.seen(c));
        if !corners.as_flattened().iter().all(|v| v.is_finite()) {
            return;
        }
        if corners.iter().all(|c| self.planes(c).iter().all(|&d| d >= 0.0)) {
            return piece(corners.map(|c| self.point(&c)));
        }
        let mut polygon = corners.to_vec();
        for plane in 0..5 {
            polygon = self.cut(&polygon, plane);
        }
        for i in 2..polygon.len() {
            piece([0, i - 1, i].map(|i| self.point(&polygon[i])));
        }
    }

    /// How far a corner is on the seen side of each plane at which triangles are cut.
    fn planes(&self, &[x, y, w, distance]: &Seen) -> [f64; 5] {
        let [width, height] = self.size;
        [
            self.camera.near().map_or(0.0, |near| distance - near),
            x + MARGIN * w,
            (width + MARGIN) * w - x,
            y + MARGIN * w,
            (height + MARGIN) * w - y,
        ]
    }

    /// The part of a polygon on the seen side of a plane (Sutherland and Hodgman 1974).
    fn cut(&self, polygon: &[Seen], plane: usize) -> Vec<Seen> {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, a) in polygon.iter().enumerate() {
            let b = &polygon[(i + 1) % polygon.len()];
            let (at_a, at_b) = (self.planes(a)[plane], self.planes(b)[plane]);
            if at_a >= 0.0 {
                kept.push(*a);
            }
            if (at_a >= 0.0) != (at_b >= 0.0) {
                // From the seen end, whichever triangle of an edge asks.
                let (from, to, d, e) =
                    if at_a >= 0.0 { (a, b, at_a, at_b) } else { (b, a, at_b, at_a) };
                let share = d / (d - e);
                kept.push(std::array::from_fn(|k| from[k] + share * (to[k] - from[k])));
            }
        }
        kept
    }

    fn point(&self, &[x, y, w, distance]: &Seen) -> Point {
        let step = |pixels: f64| (pixels * f64::from(SUBPIXELS)).round() as i32;
        let depth = self.camera.depth(distance);
        Point { x: step(x / w), y: step(y / w), z: (depth * DEPTH_STEPS).round() as i32 }
    }
}
