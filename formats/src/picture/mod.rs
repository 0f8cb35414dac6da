//! Pictures as files: PNG and JPEG in, PNG out.

mod decode;
mod encode;

pub use decode::decode;
pub use encode::png;

/// A decoded picture: rows from the top, four bytes for each pixel (sRGB and opacity, not
/// premultiplied).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// `4 * width * height` bytes.
    pub bytes: Vec<u8>,
}

impl Picture {
    /// Halves it, pixels averaged by their values in fours, until no side is longer than `side` and
    /// there are at most `pixels`; a texture shown small needs no more.
    pub(crate) fn shrink(&mut self, side: u32, pixels: u64) {
        let too_large = |p: &Self| {
            p.width.max(p.height) > side || u64::from(p.width) * u64::from(p.height) > pixels.max(1)
        };
        while too_large(self) {
            let (w, h) = (self.width.div_ceil(2), self.height.div_ceil(2));
            let mut bytes = Vec::with_capacity(4 * w as usize * h as usize);
            for y in 0..h {
                for x in 0..w {
                    for c in 0..4 {
                        let at = |dx: u32, dy: u32| {
                            let (x, y) = (
                                (2 * x + dx).min(self.width - 1),
                                (2 * y + dy).min(self.height - 1),
                            );
                            u32::from(
                                self.bytes[4 * (y as usize * self.width as usize + x as usize) + c],
                            )
                        };
                        bytes.push(((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) / 4) as u8);
                    }
                }
            }
            *self = Self { width: w, height: h, bytes };
        }
    }
}

#[cfg(test)]
mod tests;
