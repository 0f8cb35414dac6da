//! Text in pictures: glyphs of an embedded font, blended over the pixels.

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use lodc_scene::Image;

/// Open Sans; its origin and licence are noted beside it.
const FONT: &[u8] = include_bytes!("../../fonts/OpenSans-Latin.ttf");

/// A font for labels at one size.
pub(super) struct Lettering {
    font: FontRef<'static>,
    /// Pixels from the top of the tallest letter to the bottom of the deepest.
    size: f32,
    ink: [u8; 4],
}

/// A part of a picture that text may cover: left edge, width and top.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) left: usize,
    pub(super) width: usize,
    pub(super) top: usize,
}

impl Lettering {
    /// Letters of a height in pixels that can be read on a background.
    pub(super) fn new(size: f32, background: [u8; 4]) -> Self {
        let font = FontRef::try_from_slice(FONT).expect("the embedded font is one");
        Self { font, size, ink: ink(background) }
    }

    /// Pixels from one line to the next.
    pub(super) fn line_height(&self) -> usize {
        (self.size * 1.15).ceil() as usize
    }

    /// Writes a line in the middle of its area, in smaller letters if it does not fit.
    pub(super) fn write(&self, image: &mut Image, text: &str, line: Line) {
        let (_, full_width) = self.layout(text, self.size);
        let available = line.width as f32 * 0.96;
        let size =
            if full_width > available { self.size * available / full_width } else { self.size };
        let (glyphs, width) = self.layout(text, size);
        let left = line.left as f32 + (line.width as f32 - width) / 2.0;
        // The base of smaller letters is that of larger ones.
        let ascent = self.font.as_scaled(PxScale::from(self.size)).ascent();
        for mut glyph in glyphs {
            glyph.position += point(left, line.top as f32 + ascent);
            self.draw(image, glyph);
        }
    }

    /// The glyphs of a text from the origin on, with kerning, and how wide they are.
    fn layout(&self, text: &str, size: f32) -> (Vec<Glyph>, f32) {
        let font = self.font.as_scaled(PxScale::from(size));
        let (mut x, mut last, mut glyphs) = (0.0, None, Vec::new());
        for id in text.chars().map(|c| font.glyph_id(c)) {
            if let Some(last) = last {
                x += font.kern(last, id);
            }
            glyphs.push(id.with_scale_and_position(PxScale::from(size), point(x, 0.0)));
            x += font.h_advance(id);
            last = Some(id);
        }
        (glyphs, x)
    }

    fn draw(&self, image: &mut Image, glyph: Glyph) {
        let Some(outline) = self.font.outline_glyph(glyph) else { return };
        let corner = outline.px_bounds().min;
        outline.draw(|x, y, coverage| {
            let [x, y] = [x as f32 + corner.x, y as f32 + corner.y];
            let inside =
                (0.0..image.width as f32).contains(&x) && (0.0..image.height as f32).contains(&y);
            if inside {
                let start = 4 * (y as usize * image.width as usize + x as usize);
                blend(&mut image.bytes[start..start + 4], self.ink, coverage.min(1.0));
            }
        });
    }
}

/// Blends a colour over a pixel.
fn blend(pixel: &mut [u8], ink: [u8; 4], coverage: f32) {
    let opacity_below = f32::from(pixel[3]) / 255.0 * (1.0 - coverage);
    let opacity = coverage + opacity_below;
    if opacity > 0.0 {
        for (p, i) in pixel.iter_mut().zip(ink).take(3) {
            let mixed = (f32::from(i) * coverage + f32::from(*p) * opacity_below) / opacity;
            *p = (mixed + 0.5) as u8;
        }
        pixel[3] = (opacity * 255.0 + 0.5) as u8;
    }
}

/// The colour that can be read on a background.
fn ink([r, g, b, a]: [u8; 4]) -> [u8; 4] {
    // Eighths of the brightness: green looks brightest, blue darkest.
    let bright = 2 * u32::from(r) + 5 * u32::from(g) + u32::from(b);
    if bright > 8 * 110 || a < 128 { [32, 34, 40, 255] } else { [235, 235, 235, 255] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(text: &str, width: u32, background: [u8; 4]) -> (Image, Vec<(u32, u32)>) {
        let mut image = Image::filled(width, 40, background);
        let line = Line { left: 0, width: width as usize, top: 4 };
        Lettering::new(24.0, background).write(&mut image, text, line);
        let all = (0..40).flat_map(|y| (0..width).map(move |x| (x, y)));
        let inked = all.filter(|&(x, y)| image.at(x, y) != background).collect();
        (image, inked)
    }

    #[test]
    fn text_stands_in_the_middle_of_its_line_and_can_be_read() {
        let (image, inked) = written("1,234 triangles", 300, [255; 4]);
        let left = inked.iter().map(|p| p.0).min().expect("letters");
        let right = inked.iter().map(|p| p.0).max().expect("letters");
        assert!(left.abs_diff(299 - right) < 4 && right - left > 80, "{left} to {right}");
        assert!(inked.iter().all(|p| (4..32).contains(&p.1)));
        assert!(inked.iter().any(|&(x, y)| image.at(x, y)[0] < 60));
        let (dark, inked) = written("x", 40, [0, 0, 0, 255]);
        assert!(inked.iter().any(|&(x, y)| dark.at(x, y)[0] > 200));
    }

    #[test]
    fn long_text_is_made_smaller_and_letters_differ() {
        let (_, inked) = written(&"very long ".repeat(20), 200, [255; 4]);
        assert!(inked.iter().all(|p| (2..198).contains(&p.0)));
        let shapes: Vec<_> =
            "0123456789%.,".chars().map(|c| written(&c.to_string(), 40, [255; 4]).1).collect();
        for (i, shape) in shapes.iter().enumerate() {
            assert!(!shape.is_empty() && shapes[..i].iter().all(|other| other != shape));
        }
    }

    #[test]
    fn letters_on_nothing_are_opaque() {
        let (image, inked) = written("l", 40, [0; 4]);
        let most = inked.iter().map(|&(x, y)| image.at(x, y)[3]).max();
        assert!(most > Some(150), "{most:?}");
    }
}
