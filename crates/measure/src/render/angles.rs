//! Sines, cosines and tangents that are the same on every machine: those of libraries differ in
//! their last bits.

use std::f64::consts::PI;

/// Returns the sine and the cosine of an angle in degrees; whole quarter turns are exact.
pub(super) fn sin_cos(degrees: f64) -> (f64, f64) {
    let quarters = (degrees / 90.0).round();
    let x = (degrees - quarters * 90.0) * (PI / 180.0);
    // Taylor's series up to x^18, nested: x is at most π / 4, so the first term left out is below
    // the last bit.
    let square = x * x;
    let series = |first: f64| {
        (0..9).rev().fold(1.0, |sum, i| {
            let n = first + 2.0 * f64::from(i);
            1.0 - square / (n * (n + 1.0)) * sum
        })
    };
    let (sin, cos) = (x * series(2.0), series(1.0));
    match quarters.rem_euclid(4.0) as u32 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Returns the tangent of half an angle in degrees, above 0 and below 180.
pub(super) fn tan_of_half(degrees: f64) -> f64 {
    let (sin, cos) = sin_cos(degrees / 2.0);
    sin / cos
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_those_of_the_library_but_for_the_last_bits() {
        for step in -4000..4000 {
            let degrees = f64::from(step) * 0.177;
            let (sin, cos) = sin_cos(degrees);
            let (s, c) = degrees.to_radians().sin_cos();
            assert!((sin - s).abs() < 4e-15 && (cos - c).abs() < 4e-15, "{degrees}");
            if (1..=1000).contains(&step) {
                let expected = (degrees.to_radians() / 2.0).tan();
                assert!((tan_of_half(degrees) / expected - 1.0).abs() < 4e-13, "{degrees}");
            }
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        let turns = [0.0, 90.0, 180.0, 270.0, -90.0, 360.0].map(sin_cos);
        let expected = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (-1.0, 0.0), (0.0, 1.0)];
        assert_eq!(turns, expected);
    }
}
