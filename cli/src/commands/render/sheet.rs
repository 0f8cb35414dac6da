//! Several pictures side by side, with labels.

use super::RenderArgs;
use super::cells::Cell;
use super::colours::encoded;
use super::font::{HEIGHT, WIDTH, glyph};
use super::heat::Heat;
use crate::exit::{Failure, Outcome, Status};
use crate::text::distance;
use lodc_formats::picture::Picture;

/// More pixels than this do not become one picture.
const MOST_PIXELS: u64 = 1 << 28;

/// Puts pictures of one size into rows, each with its label below.
///
/// # Errors
/// If that is more than a picture may hold.
pub(super) fn compose(
    args: &RenderArgs,
    cells: &[Cell],
    heat: Option<&Heat>,
    pictures: &[Picture],
) -> Outcome<Picture> {
    let (width, height) =
        pictures.first().map_or((0, 0), |p| (p.width as usize, p.height as usize));
    let count = pictures.len();
    // Rows of at most four, as even as can be.
    let columns =
        args.columns.map_or_else(|| count.div_ceil(count.div_ceil(4)), |c| (c as usize).min(count));
    let scale = (width / 240).max(1);
    let line = (HEIGHT + 2) * scale;
    let below = 2 * line + 6 * scale;
    let legend = if heat.is_some() { 2 * line + 8 * scale } else { 0 };
    let rows = count.div_ceil(columns) * (height + below);
    let (across, down) = (columns * width, rows + legend);
    if (across as u64) * (down as u64) > MOST_PIXELS {
        let message = format!(
            "a contact sheet of {across} x {down} pixels is too large: use a smaller --size"
        );
        return Err(Failure::new(Status::Limit, message));
    }
    let mut sheet = Sheet::new(across, down, args.background);
    let ink = ink(args.background);
    for (i, (picture, cell)) in pictures.iter().zip(cells).enumerate() {
        let (x, y) = (i % columns * width, i / columns * (height + below));
        sheet.put(picture, x, y);
        for (number, text) in cell.label().iter().enumerate() {
            let top = y + height + 2 * scale + number * line;
            sheet.write(text, x, width, top, scale, ink);
        }
    }
    if let Some(heat) = heat {
        sheet.legend(heat, rows, scale, ink);
    }
    Ok(sheet.0)
}

/// What can be read on a background.
fn ink([r, g, b, a]: [u8; 4]) -> [u8; 4] {
    let bright = 2 * u32::from(r) + 5 * u32::from(g) + u32::from(b);
    if bright > 8 * 110 || a < 128 { [32, 34, 40, 255] } else { [235, 235, 235, 255] }
}

struct Sheet(Picture);

impl Sheet {
    fn new(width: usize, height: usize, colour: [u8; 4]) -> Self {
        Self(Picture {
            width: width as u32,
            height: height as u32,
            bytes: colour.repeat(width * height),
        })
    }

    fn put(&mut self, picture: &Picture, x: usize, y: usize) {
        let row = 4 * picture.width as usize;
        for (i, from) in picture.bytes.chunks_exact(row).enumerate() {
            let start = 4 * ((y + i) * self.0.width as usize + x);
            self.0.bytes[start..start + row].copy_from_slice(from);
        }
    }

    /// Writes a line in the middle of a column; what does not fit is cut off.
    fn write(
        &mut self,
        text: &str,
        left: usize,
        width: usize,
        top: usize,
        scale: usize,
        ink: [u8; 4],
    ) {
        let step = (WIDTH + 1) * scale;
        let length = (text.chars().count() * step).saturating_sub(scale);
        let start = left + width.saturating_sub(length) / 2;
        for (i, c) in text.chars().enumerate() {
            for (row, bits) in glyph(c).into_iter().enumerate() {
                for column in (0..WIDTH).filter(|column| bits >> (WIDTH - 1 - column) & 1 == 1) {
                    let (x, y) = (start + i * step + column * scale, top + row * scale);
                    if x + scale <= left + width {
                        self.fill(x, y, scale, ink);
                    }
                }
            }
        }
    }

    /// What the colours of a heat map mean: a bar, and the distances at its ends.
    fn legend(&mut self, heat: &Heat, top: usize, scale: usize, ink: [u8; 4]) {
        let across = self.0.width as usize;
        let length = (across / scale * 3 / 5).clamp(1, 400);
        let left = (across - length * scale) / 2;
        for i in 0..length {
            let [r, g, b] = super::colours::heat(i as f64 / length.max(2) as f64).map(encoded);
            for row in 0..HEIGHT {
                self.fill(left + i * scale, top + row * scale, scale, [r, g, b, 255]);
            }
        }
        let share = if heat.diagonal > 0.0 { heat.largest / heat.diagonal * 100.0 } else { 0.0 };
        let text =
            format!("distance 0 to {} ({share:.3} % of the diagonal)", distance(heat.largest));
        self.write(&text, 0, across, top + (HEIGHT + 4) * scale, scale, ink);
    }

    fn fill(&mut self, x: usize, y: usize, side: usize, colour: [u8; 4]) {
        for row in y..y + side {
            let start = 4 * (row * self.0.width as usize + x);
            self.0.bytes[start..start + 4 * side].copy_from_slice(&colour.repeat(side));
        }
    }
}
