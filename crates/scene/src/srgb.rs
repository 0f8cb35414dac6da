//! Conversion between sRGB values and linear light (IEC 61966-2-1).

/// Returns the linear light, 0 to 1, of an sRGB value from 0 to 1.
#[must_use]
pub fn to_linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Returns the sRGB value, clamped to 0 to 1, of linear light.
#[must_use]
pub fn srgb_value(light: f32) -> f32 {
    let v =
        if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    v.clamp(0.0, 1.0)
}

/// Returns the sRGB value of linear light as a byte.
#[must_use]
pub fn to_srgb(light: f32) -> u8 {
    (srgb_value(light) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_srgb_value_survives_linear_light() {
        for v in 0..=255u8 {
            assert_eq!(to_srgb(to_linear(f32::from(v) / 255.0)), v);
        }
    }
}
