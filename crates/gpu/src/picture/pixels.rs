//! Finished pictures, and how large ones become small.

/// A picture: rows from the top, four bytes for each pixel (sRGB and opacity, not premultiplied).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pixels {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `4 * width * height` bytes.
    pub bytes: Vec<u8>,
}

impl Pixels {
    /// One colour everywhere.
    #[must_use]
    pub fn filled(width: u32, height: u32, colour: [u8; 4]) -> Self {
        Self { width, height, bytes: colour.repeat(width as usize * height as usize) }
    }

    /// The colour at a place.
    ///
    /// # Panics
    /// If it is outside.
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> [u8; 4] {
        assert!(x < self.width && y < self.height, "({x}, {y}) is outside");
        let start = 4 * (y as usize * self.width as usize + x as usize);
        std::array::from_fn(|c| self.bytes[start + c])
    }
}

/// Halves a picture of premultiplied colours, whose width and height are even, in linear light; the
/// result is not premultiplied any more.
pub(super) fn halved(width: u32, height: u32, rows: &[u8]) -> Pixels {
    let linear = linear_table();
    let (w, h) = (width as usize / 2, height as usize / 2);
    let mut bytes = Vec::with_capacity(4 * w * h);
    for y in 0..h {
        for x in 0..w {
            let mut sum = [0.0f32; 4];
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let start = 4 * ((2 * y + dy) * width as usize + 2 * x + dx);
                let texel = &rows[start..start + 4];
                for c in 0..3 {
                    sum[c] += linear[usize::from(texel[c])];
                }
                sum[3] += f32::from(texel[3]) / 255.0;
            }
            let opacity = sum[3] / 4.0;
            for c in &sum[..3] {
                bytes.push(if opacity > 0.0 { encoded(c / 4.0 / opacity) } else { 0 });
            }
            bytes.push(quantised(opacity));
        }
    }
    Pixels { width: w as u32, height: h as u32, bytes }
}

/// The light of every sRGB value.
pub(super) fn linear_table() -> [f32; 256] {
    std::array::from_fn(|i| linear(i as f32 / 255.0))
}

/// The light of an sRGB value from 0 to 1 (IEC 61966-2-1).
pub(super) fn linear(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB value of light, in a byte.
pub(super) fn encoded(light: f32) -> u8 {
    quantised(if light <= 0.003_130_8 {
        light * 12.92
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    })
}

fn quantised(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_srgb_value_survives_linear_light() {
        for (v, light) in (0..=255).zip(linear_table()) {
            assert_eq!(encoded(light), v);
        }
    }

    #[test]
    fn halving_mixes_light_and_keeps_the_colour_of_half_covered_pixels() {
        // Black and white in equal parts are brighter than the number between them.
        let grey = halved(2, 2, &[[0, 0, 0, 255], [255; 4], [255; 4], [0, 0, 0, 255]].concat());
        assert_eq!((grey.width, grey.height, grey.at(0, 0)), (1, 1, [188, 188, 188, 255]));
        let red = halved(2, 2, &[[255, 0, 0, 255], [0; 4], [0; 4], [0; 4]].concat());
        assert_eq!(red.at(0, 0), [255, 0, 0, 64]);
    }
}
