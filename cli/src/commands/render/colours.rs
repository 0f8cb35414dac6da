//! Colours that stand for numbers.

/// A colour for every number, neighbours far apart, linear. Grey and black never occur.
pub(super) fn distinct(number: u32) -> [f32; 3] {
    // Steps of the golden section visit all hues evenly, however many there are.
    let hue = (f64::from(number) * 0.618_033_988_749_895).fract() * 6.0;
    let saturation = [0.62, 0.8, 0.5][number as usize % 3];
    let value = [0.95, 0.8][number as usize / 3 % 2];
    let channel = |shift: f64| {
        let k = (hue + shift) % 6.0;
        let share = k.min(4.0 - k).clamp(0.0, 1.0);
        linear((value * (1.0 - saturation * share)) as f32)
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

/// From 0 (blue) over green and yellow to 1 (red), linear.
pub(super) fn heat(share: f64) -> [f32; 3] {
    const STOPS: [[f32; 3]; 6] = [
        [0.19, 0.22, 0.60],
        [0.16, 0.55, 0.80],
        [0.30, 0.76, 0.52],
        [0.80, 0.85, 0.30],
        [0.97, 0.60, 0.20],
        [0.78, 0.12, 0.15],
    ];
    let at = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let below = (at as usize).min(STOPS.len() - 2);
    let part = (at - below as f64) as f32;
    std::array::from_fn(|c| {
        linear(STOPS[below][c] + part * (STOPS[below + 1][c] - STOPS[below][c]))
    })
}

/// The light of an sRGB value from 0 to 1 (IEC 61966-2-1).
pub(super) fn linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB value of light, in a byte.
pub(super) fn encoded(light: f32) -> u8 {
    let v =
        if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
    (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_numbers_have_different_colours() {
        let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 0.1);
        for i in 0..1000 {
            for j in 1..4 {
                assert!(!near(distinct(i), distinct(i + j)), "{i} and {}", i + j);
            }
        }
    }

    #[test]
    fn heat_starts_blue_and_ends_red() {
        let (cold, hot) = (heat(0.0), heat(1.0));
        assert!(cold[2] > 2.0 * cold[0] && hot[0] > 2.0 * hot[2]);
        assert_eq!((heat(-1.0), heat(2.0)), (cold, hot));
    }
}
