//! Conversion between sRGB values and linear light (IEC 61966-2-1). Powers are roots by Newton's
//! method, which give the same bits on every machine.

/// Returns the linear light, 0 to 1, of an sRGB value from 0 to 1.
#[must_use]
pub fn to_linear(v: f32) -> f32 {
    let v = f64::from(v);
    let light = if v <= 0.04045 {
        v / 12.92
    } else {
        // To the power of 2.4.
        let square = ((v + 0.055) / 1.055).powi(2);
        square * fifth_root(square)
    };
    light as f32
}

/// Returns the sRGB value, clamped to 0 to 1, of linear light.
#[must_use]
pub fn srgb_value(light: f32) -> f32 {
    let light = f64::from(light).clamp(0.0, 1.0);
    let v = if light <= 0.003_130_8 {
        light * 12.92
    } else {
        // To the power of 5/12.
        1.055 * cube_root(light.powi(5)).sqrt().sqrt() - 0.055
    };
    v as f32
}

/// Returns the sRGB value of linear light as a byte.
#[must_use]
pub fn to_srgb(light: f32) -> u8 {
    (srgb_value(light) * 255.0 + 0.5) as u8
}

/// The cube root of a positive number.
fn cube_root(x: f64) -> f64 {
    let mut y = first_guess(x, 3);
    for _ in 0..4 {
        y = (2.0 * y + x / (y * y)) / 3.0;
    }
    y
}

/// The fifth root of a positive number.
fn fifth_root(x: f64) -> f64 {
    let mut y = first_guess(x, 5);
    for _ in 0..5 {
        let square = y * y;
        y = (4.0 * y + x / (square * square)) / 5.0;
    }
    y
}

/// A root within some percent: the bits of a float are nearly its logarithm.
fn first_guess(x: f64, degree: u64) -> f64 {
    const ONE: u64 = 1.0f64.to_bits();
    f64::from_bits(x.to_bits() / degree + (ONE - ONE / degree))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_srgb_value_survives_linear_light() {
        for v in 0..=255u8 {
            assert_eq!(to_srgb(to_linear(f32::from(v) / 255.0)), v);
        }
        assert_eq!((to_linear(1.0), to_linear(0.0)), (1.0, 0.0));
        assert_eq!((srgb_value(1.0), srgb_value(7.0), srgb_value(-1.0)), (1.0, 1.0, 0.0));
    }

    #[test]
    fn roots_are_those_of_the_standard() {
        for i in 1..=10_000 {
            let v = i as f32 / 10_000.0;
            let x = f64::from(v);
            let expected = if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
            assert!((f64::from(to_linear(v)) - expected).abs() <= 6e-8 * expected, "{v}");
            let expected =
                if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
            assert!((f64::from(srgb_value(v)) - expected).abs() <= 6e-8, "{v}");
        }
    }
}
