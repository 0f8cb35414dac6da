//! Colour scales for pictures: one for shares from 0 to 1, one that tells numbers apart.

/// The colour of a share: from 0 (blue) over green, yellow and orange to 1 (red), in sRGB. The
/// scheme is Spectral (Harrower and Brewer 2003), reversed.
#[must_use]
pub fn heat(share: f64) -> [u8; 3] {
    let colorous::Color { r, g, b } =
        colorous::SPECTRAL.eval_continuous(1.0 - share.clamp(0.0, 1.0));
    [r, g, b]
}

/// A colour for every number, neighbours far apart, in sRGB. Grey and black never occur.
#[must_use]
pub fn distinct(number: u32) -> [u8; 3] {
    // Steps of the golden ratio visit all hues evenly, however many numbers there are; palettes of
    // libraries have about a dozen colours. Saturations and values are chosen by hand.
    let hue = (f64::from(number) * 0.618_033_988_749_895).fract() * 6.0;
    let saturation = [0.62, 0.8, 0.5][number as usize % 3];
    let value = [0.95, 0.8][number as usize / 3 % 2];
    let channel = |shift: f64| {
        let k = (hue + shift) % 6.0;
        let share = k.min(4.0 - k).clamp(0.0, 1.0);
        (value * (1.0 - saturation * share) * 255.0) as u8
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_numbers_have_different_colours() {
        let near = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).all(|(x, y)| x.abs_diff(y) < 25);
        for i in 0..1000 {
            for j in 1..4 {
                assert!(!near(distinct(i), distinct(i + j)), "{i} and {}", i + j);
            }
        }
    }

    #[test]
    fn heat_starts_blue_and_ends_red() {
        let (cold, hot) = (heat(0.0), heat(1.0));
        assert!(cold[2] > cold[0] && hot[0] > 2 * hot[2], "{cold:?} {hot:?}");
        assert_eq!((heat(-1.0), heat(2.0)), (cold, hot));
    }
}
