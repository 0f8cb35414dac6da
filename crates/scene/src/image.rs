//! Decoded images, and their halved sizes for texture levels (mipmaps).

use crate::srgb::{to_linear, to_srgb};

/// An image: rows from the top, four bytes for each pixel (sRGB and opacity, not premultiplied).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// `4 * width * height` bytes.
    pub bytes: Vec<u8>,
}

impl Image {
    /// An image of one colour.
    #[must_use]
    pub fn filled(width: u32, height: u32, colour: [u8; 4]) -> Self {
        Self { width, height, bytes: colour.repeat(width as usize * height as usize) }
    }

    /// Returns a pixel.
    ///
    /// # Panics
    /// If it is outside.
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> [u8; 4] {
        assert!(x < self.width && y < self.height, "({x}, {y}) is outside");
        let start = 4 * (y as usize * self.width as usize + x as usize);
        std::array::from_fn(|c| self.bytes[start + c])
    }

    /// Returns the image at half its size, as graphics devices count the levels of a texture:
    /// rounded down, at least one pixel. Pixels are averaged in linear light and weighted by
    /// opacity, so that the colours of invisible pixels do not bleed in. If a side is odd, its last
    /// row or column is averaged with the two before it.
    #[must_use]
    pub fn halved(&self) -> Self {
        let (w, h) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let light: [f32; 256] = std::array::from_fn(|i| to_linear(i as f32 / 255.0));
        let mut bytes = Vec::with_capacity(4 * w as usize * h as usize);
        // The old rows or columns that a new one is made of.
        let source_range =
            |i: u32, new: u32, old: u32| if i + 1 == new { 2 * i..old } else { 2 * i..2 * i + 2 };
        for y in 0..h {
            for x in 0..w {
                let mut mean = Mean::default();
                for oy in source_range(y, h, self.height) {
                    for ox in source_range(x, w, self.width) {
                        mean.add(self.at(ox, oy), &light);
                    }
                }
                bytes.extend(mean.pixel());
            }
        }
        Self { width: w, height: h, bytes }
    }

    /// Returns the image and all its halves, down to one pixel.
    #[must_use]
    pub fn levels(self) -> Vec<Self> {
        let mut levels = vec![self];
        while let Some(last) = levels.last()
            && (last.width, last.height) != (1, 1)
        {
            levels.push(last.halved());
        }
        levels
    }

    /// Halves the image until no side is longer than `max_side` and it has at most `max_pixels`
    /// (but not beyond one pixel).
    pub fn shrink(&mut self, max_side: u32, max_pixels: u64) {
        while self.width.max(self.height) > max_side
            || u64::from(self.width) * u64::from(self.height) > max_pixels.max(1)
        {
            *self = self.halved();
        }
    }
}

/// The mean of some pixels.
#[derive(Default)]
struct Mean {
    /// Sum of linear light weighted by opacity.
    weighted_light: [f32; 3],
    /// Sum of linear light without weights, for pixels that are all invisible.
    light: [f32; 3],
    /// Sum of opacities, each 0 to 1.
    opacity: f32,
    /// Number of pixels.
    pixels: f32,
}

impl Mean {
    fn add(&mut self, pixel: [u8; 4], light: &[f32; 256]) {
        let opacity = f32::from(pixel[3]) / 255.0;
        for c in 0..3 {
            let light = light[usize::from(pixel[c])];
            self.weighted_light[c] += opacity * light;
            self.light[c] += light;
        }
        self.opacity += opacity;
        self.pixels += 1.0;
    }

    fn pixel(&self) -> [u8; 4] {
        let [r, g, b] = if self.opacity > 0.0 {
            self.weighted_light.map(|c| to_srgb(c / self.opacity))
        } else {
            self.light.map(|c| to_srgb(c / self.pixels))
        };
        [r, g, b, (self.opacity / self.pixels * 255.0 + 0.5) as u8]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_end_at_one_pixel_whatever_the_shape() {
        for (w, h) in [(1, 1), (7, 1), (1, 4), (5, 3), (16, 16)] {
            let all = Image::filled(w, h, [200; 4]).levels();
            assert_eq!(all.len() as u32, 32 - w.max(h).leading_zeros());
            assert_eq!(all.last().map(|l| (l.width, l.height)), Some((1, 1)));
            assert!(all.iter().all(|l| *l == Image::filled(l.width, l.height, [200; 4])));
        }
    }

    #[test]
    fn light_is_averaged_and_transparent_pixels_do_not_bleed() {
        let two = |a: [u8; 4], b: [u8; 4]| {
            Image { width: 2, height: 1, bytes: [a, b].concat() }.halved().bytes
        };
        // The mean of black and white light has an sRGB value above 128.
        assert_eq!(two([0, 0, 0, 255], [255; 4]), [188, 188, 188, 255]);
        assert_eq!(two([255, 0, 0, 255], [0, 255, 0, 0]), [255, 0, 0, 128]);
    }

    #[test]
    fn shrinking_halves_until_both_limits_hold() {
        let mut image = Image::filled(64, 16, [9; 4]);
        image.shrink(32, 100);
        assert_eq!((image.width, image.height), (16, 4));
    }
}
