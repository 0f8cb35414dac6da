//! The expected squared difference of pixels, for a light at the camera and views from all sides.

use super::vectors::Vec3x4;
use glam::Vec4;

/// Ambient light relative to the lamp at the camera: 0.15 / 0.85.
const AMBIENT: f32 = 0.176_470_6;
/// The largest error of a white point: it shows the background. The mean of (0.15 + 0.85 cos)²
/// over all views that see it, in the unit of [`ShadingError`].
const MAX_SHADING: f32 = 4.0 * AMBIENT * AMBIENT + 16.0 / 3.0 * AMBIENT + 2.0;
/// Error of a point that no face covers any more. It is less than [`MAX_SHADING`] (3.07), since
/// most often another part of the surface is behind it. Chosen by image errors; the figures
/// were not kept.
pub(super) const UNCOVERED: f32 = 1.5;
/// The largest error by distance and cover, about that of a pixel that shows something else
/// ([`MAX_SHADING`]). Chosen by hand.
pub(super) const MAX_GEOMETRY: f32 = 3.0;

/// The error of shading a point as a function of the cosine between two normals: the mean of
///
/// ```text
/// ((a + l n·v) c − (a + l n'·v) c')²
/// ```
///
/// over all views v that see the point, weighted by its projected area. n and c are the normal and
/// the colour of the input, n' and c' those that are shown; a = 0.15 is the ambient light and
/// l = 0.85 the lamp at the camera. The unit is l²/4, so that equal white colours with normals that
/// differ by a small d give d². `T` is one number, or four in lanes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ShadingError<T = f32> {
    /// Coefficients of the powers 0, 1 and 2 of one minus the cosine.
    coefficients: [T; 3],
    /// The largest error, whatever the cosine.
    limit: T,
}

impl ShadingError {
    /// The error of a point that shows its own colour, whose channels have this mean square.
    pub(super) fn of_own_colour(power: f32) -> Self {
        Self { coefficients: [0.0, 2.0 * power, power], limit: MAX_SHADING * power }
    }
}

impl ShadingError<[f32; 4]> {
    /// Sets the error of lane `i`.
    #[inline]
    pub(super) fn set(&mut self, i: usize, one: &ShadingError) {
        for k in 0..3 {
            self.coefficients[k][i] = one.coefficients[k];
        }
        self.limit[i] = one.limit;
    }

    /// The four in lanes.
    #[inline]
    pub(super) fn lanes(&self) -> ShadingError<Vec4> {
        let [constant, linear, square] = self.coefficients;
        ShadingError {
            coefficients: [constant.into(), linear.into(), square.into()],
            limit: self.limit.into(),
        }
    }
}

impl ShadingError<Vec4> {
    /// The errors of four points of colours `was` that show the colours `now`; `extra` is added,
    /// whatever the normals.
    pub(super) fn of_colours(was: Vec3x4, now: Vec3x4, extra: Vec4) -> Self {
        const CONSTANT: f32 = 2.0 + 4.0 * AMBIENT * AMBIENT + 16.0 / 3.0 * AMBIENT;
        let apart = was.minus_each(now);
        let (was_squared, now_squared, was_now) = (was.dot(was), now.dot(now), was.dot(now));
        let linear =
            was_now * 4.0 - now_squared * 2.0 + (was_now - now_squared) * (16.0 / 3.0 * AMBIENT);
        let coefficients = [apart.dot(apart) * CONSTANT, linear, now_squared].map(|c| c / 3.0);
        let [constant, linear, square] = coefficients;
        Self {
            coefficients: [constant + extra, linear, square],
            limit: was_squared.max(now_squared) * (MAX_SHADING / 3.0),
        }
    }

    /// One of the four.
    pub(super) fn one(&self, i: usize) -> ShadingError {
        ShadingError { coefficients: self.coefficients.map(|c| c[i]), limit: self.limit[i] }
    }

    /// The errors for the cosines between the normals.
    #[inline]
    pub(super) fn error(&self, cosine: Vec4) -> Vec4 {
        let turned = Vec4::ONE - cosine;
        let [constant, linear, square] = self.coefficients;
        (constant + turned * (linear + turned * square)).max(Vec4::ZERO).min(self.limit)
    }
}

#[cfg(test)]
mod tests {
    use super::ShadingError;
    use crate::metric::hybrid::vectors::Vec3x4;
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
            let [was, now] = [c, d].map(|shade| Vec3x4::new(&[Vec3::splat(shade); 4]));
            let error = ShadingError::of_colours(was, now, Vec4::ZERO);
            let said = error.error(Vec4::splat(cosine)).z;
            if c == d {
                let own = ShadingError::of_own_colour(c * c);
                for (a, b) in own.coefficients.into_iter().zip(error.one(1).coefficients) {
                    assert!((a - b).abs() < 1e-6, "{own:?}");
                }
            }
            let expected = mean(n, c, d);
            assert!((said - expected).abs() < 0.02 * expected + 0.01, "{said}, not {expected}");
        }
    }
}
