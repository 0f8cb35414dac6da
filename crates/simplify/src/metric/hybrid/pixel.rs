//! The expected squared difference of pixels, for a light at the camera and views from all sides.

use super::appearance::Colour;
use glam::Vec4;

/// Ambient light relative to the lamp at the camera: 0.15 / 0.85.
const AMBIENT: f32 = 0.176_470_6;
/// The largest error of a place in white: it shows the background. The mean of (0.15 + 0.85 cos)²
/// over all views that see it, in the unit of [`Shading`].
const MAX_SHADING: f32 = 4.0 * AMBIENT * AMBIENT + 16.0 / 3.0 * AMBIENT + 2.0;
/// Error of a place that nothing covers. Less than [`MAX_SHADING`] (3.07), since most often another
/// part of the surface is behind it. Chosen by image errors; the figures are not kept.
pub(super) const UNCOVERED: f32 = 1.5;
/// The largest error by distance and cover: a pixel can be no more than wrong.
pub(super) const MAX_GEOMETRY: f32 = 3.0;

/// The error of shading a place as a function of the cosine between the normals: the mean of
/// ((a + l n·v) c − (a + l n'·v) c')² over all views v that see the place, weighted by its
/// projected area, with a = 0.15 and l = 0.85 the light. In units of l²/4, so that equal white
/// colours with normals that differ by a small d give d². One number, or four in lanes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shading<T = f32> {
    /// Coefficients of the powers of one minus the cosine.
    coefficients: [T; 3],
    most: T,
}

impl Shading {
    /// That of a place of one colour that shows another.
    pub(super) fn new(was: Colour, now: Colour) -> Self {
        let (c, d) = (was.channels(), now.channels());
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let apart = [0, 1, 2].map(|i| c[i] - d[i]);
        let (cc, dd, cd) = (dot(c, c), dot(d, d), dot(c, d));
        let constant = dot(apart, apart) * (2.0 + 4.0 * AMBIENT * AMBIENT + 16.0 / 3.0 * AMBIENT);
        let linear = 4.0 * cd - 2.0 * dd + 16.0 / 3.0 * AMBIENT * (cd - dd);
        Self {
            coefficients: [constant / 3.0, linear / 3.0, dd / 3.0],
            most: MAX_SHADING * cc.max(dd) / 3.0,
        }
    }
}

impl Shading {
    /// With an error that does not depend on normals.
    pub(super) fn plus(mut self, error: f32) -> Self {
        self.coefficients[0] += error;
        self
    }
}

impl Shading<[f32; 4]> {
    /// Sets one of four.
    #[inline]
    pub(super) fn set(&mut self, i: usize, one: &Shading) {
        for k in 0..3 {
            self.coefficients[k][i] = one.coefficients[k];
        }
        self.most[i] = one.most;
    }

    /// The four in lanes.
    #[inline]
    pub(super) fn lanes(&self) -> Shading<Vec4> {
        let [constant, linear, square] = self.coefficients;
        Shading {
            coefficients: [constant.into(), linear.into(), square.into()],
            most: self.most.into(),
        }
    }
}

impl Shading<Vec4> {
    /// The errors for the cosines between the normals.
    #[inline]
    pub(super) fn error(&self, cosine: Vec4) -> Vec4 {
        let turned = Vec4::ONE - cosine;
        let [constant, linear, square] = self.coefficients;
        (constant + turned * (linear + turned * square)).max(Vec4::ZERO).min(self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::Shading;
    use crate::metric::hybrid::appearance::Colour;
    use glam::{Vec3, Vec4};

    #[test]
    fn it_is_the_mean_over_views() {
        // Numerically, over a hemisphere of views, weighted by the cosine.
        let mean = |n: Vec3, c: f32, d: f32| {
            let (mut sum, mut weight) = (0.0, 0.0);
            for i in 0..200 {
                let z = (i as f32 + 0.5) / 200.0;
                for j in 0..64 {
                    let turn = std::f32::consts::TAU * j as f32 / 64.0;
                    let r = (1.0 - z * z).sqrt();
                    let v = Vec3::new(r * turn.cos(), r * turn.sin(), z);
                    let seen = (0.15 + 0.85 * z) * c - (0.15 + 0.85 * n.dot(v)) * d;
                    sum += z * seen * seen;
                    weight += z;
                }
            }
            sum / weight / (0.85 * 0.85 / 4.0)
        };
        for (cosine, c, d) in
            [(0.9_f32, 1.0, 1.0), (0.8, 0.6, 0.6), (0.7, 1.0, 0.4), (1.0, 0.2, 0.8)]
        {
            let n = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
            let mut four = Shading::default();
            four.set(2, &Shading::new(Colour::new([c; 3]), Colour::new([d; 3])));
            let said = four.lanes().error(Vec4::splat(cosine)).z;
            let expected = mean(n, c, d);
            assert!((said - expected).abs() < 0.02 * expected + 0.01, "{said}, not {expected}");
        }
    }
}
