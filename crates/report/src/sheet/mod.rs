//! Composes several pictures of one size into a sheet, with labels and a legend.

mod label;

use label::{Lettering, Line};
use lodc_scene::Image;

/// Lines of a label.
const LINES: usize = 2;

/// Pictures of one size in rows.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<'a> {
    /// The pictures, at least one.
    pub pictures: &'a [Image],
    /// Pictures in a row; none: at most four, and rows as even as can be.
    pub columns: Option<usize>,
    /// Two lines below each picture; empty for no text at all, not below the sheet either.
    pub labels: &'a [[String; 2]],
    /// sRGB colour and opacity behind the text.
    pub background: [u8; 4],
}

/// A bar of colours from the left to the right end of a scale, and a line below it.
#[derive(Clone, Copy)]
pub struct Legend<'a> {
    /// The sRGB colour of a share, 0 to 1.
    pub colour: fn(f64) -> [u8; 3],
    /// The meaning of the bar.
    pub text: &'a str,
}

impl Sheet<'_> {
    /// Pictures in a row.
    fn columns(&self) -> usize {
        let count = self.pictures.len();
        self.columns.map_or_else(|| count.div_ceil(count.div_ceil(4)), |c| c.min(count))
    }

    fn lettering(&self) -> Lettering {
        Lettering::new((self.pictures[0].width as f32 / 24.0).max(12.0), self.background)
    }

    /// Pixels down of the text below each picture, and of that below the sheet.
    fn text_heights(&self, has_legend: bool) -> [usize; 2] {
        let line = self.lettering().line_height();
        let has_labels = !self.labels.is_empty();
        [
            if has_labels { LINES * line + line / 2 } else { 0 },
            if has_labels && has_legend { 3 * line } else { 0 },
        ]
    }

    /// Pixels across and down, with a legend or without.
    ///
    /// # Panics
    /// If there is no picture.
    #[must_use]
    pub fn size(&self, has_legend: bool) -> [usize; 2] {
        let [label, legend_height] = self.text_heights(has_legend);
        let (width, height) = (self.pictures[0].width as usize, self.pictures[0].height as usize);
        let columns = self.columns();
        [columns * width, self.pictures.len().div_ceil(columns) * (height + label) + legend_height]
    }

    /// Puts the pictures into one.
    ///
    /// # Panics
    /// If there is no picture.
    #[must_use]
    pub fn compose(&self, legend: Option<Legend<'_>>) -> Image {
        let [label, legend_height] = self.text_heights(legend.is_some());
        let [across, down] = self.size(legend.is_some());
        let (columns, lettering) = (self.columns(), self.lettering());
        let mut sheet = Image::filled(across as u32, down as u32, self.background);
        for (i, picture) in self.pictures.iter().enumerate() {
            let (width, height) = (picture.width as usize, picture.height as usize);
            let (left, top) = (i % columns * width, i / columns * (height + label));
            copy_into(&mut sheet, picture, left, top);
            for (number, text) in self.labels.get(i).into_iter().flatten().enumerate() {
                let top = top + height + number * lettering.line_height();
                lettering.write(&mut sheet, text, Line { left, width, top });
            }
        }
        if let Some(legend) = legend.filter(|_| legend_height > 0) {
            write_legend(&mut sheet, legend, down - legend_height, &lettering);
        }
        sheet
    }
}

/// Copies a picture to pixel (`x`, `y`) of a sheet.
fn copy_into(sheet: &mut Image, picture: &Image, x: usize, y: usize) {
    let row = 4 * picture.width as usize;
    for (i, from) in picture.bytes.chunks_exact(row).enumerate() {
        let start = 4 * ((y + i) * sheet.width as usize + x);
        sheet.bytes[start..start + row].copy_from_slice(from);
    }
}

fn write_legend(sheet: &mut Image, legend: Legend<'_>, top: usize, lettering: &Lettering) {
    let across = sheet.width as usize;
    let length = (across * 3 / 5).clamp(1, 800);
    let left = (across - length) / 2;
    let line = lettering.line_height();
    for row in top + line / 3..top + line {
        for i in 0..length {
            let [r, g, b] = (legend.colour)(i as f64 / length.max(2) as f64);
            let start = 4 * (row * across + left + i);
            sheet.bytes[start..start + 4].copy_from_slice(&[r, g, b, 255]);
        }
    }
    let top = top + line + line / 4;
    lettering.write(sheet, legend.text, Line { left: 0, width: across, top });
}
