//! The expected squared difference of pixels, for a light at the camera and views from all sides.

use super::appearance::Colour;

/// Ambient light beside the lamp at the camera: 0.15 / 0.85.
const AMBIENT: f32 = 0.176_470_6;
/// The error of a white place that shows the background: the mean of (0.15 + 0.85 cos)² over all
/// views that see it, in the unit of [`shading_error`].
pub(super) const UNCOVERED: f32 = 4.0 * AMBIENT * AMBIENT + 16.0 / 3.0 * AMBIENT + 2.0;

/// The mean of ((a + l n·v) c − (a + l n'·v) c')² over all views v that see a place, weighted by its
/// projected area: `cosine` is n·n', a = 0.15 and l = 0.85 the light. In units of l²/4, so that equal
/// white colours with normals that differ by a small d give d².
#[inline]
pub(super) fn shading_error(cosine: f32, was: Colour, now: Colour) -> f32 {
    let t = cosine;
    if was == now {
        let turned = 1.0 - t;
        return (was.power() * turned * (2.0 + turned)).min(UNCOVERED * was.power());
    }
    let (c, d) = (was.channels(), now.channels());
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (cc, dd, cd) = (dot(c, c), dot(d, d), dot(c, d));
    let ambient = 4.0 * AMBIENT * AMBIENT * (cc + dd - 2.0 * cd)
        + 16.0 / 3.0 * AMBIENT * (cc - (1.0 + t) * cd + t * dd);
    let lamp = 2.0 * cc + dd * (1.0 + t * t) - 4.0 * t * cd;
    ((ambient + lamp) / 3.0).clamp(0.0, UNCOVERED * cc.max(dd) / 3.0)
}
