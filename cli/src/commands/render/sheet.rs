//! Several pictures side by side, with labels.

use super::RenderArgs;
use super::cells::Cell;
use super::heat::Heat;
use super::label::{Lettering, Line};
use crate::colours;
use crate::exit::{Failure, Outcome, Status};
use crate::text::distance;
use lodc_scene::Image;

/// More pixels than this do not become one picture.
const MAX_PIXELS: u64 = 1 << 28;
/// Lines of a label.
const LINES: usize = 2;

/// Puts pictures of one size into rows, each with its label below unless there are none.
///
/// # Errors
/// If that is more than a picture may hold.
pub(super) fn compose(
    args: &RenderArgs,
    cells: &[Cell],
    heat: Option<&Heat>,
    pictures: &[Image],
) -> Outcome<Image> {
    let (width, height) =
        pictures.first().map_or((0, 0), |p| (p.width as usize, p.height as usize));
    let count = pictures.len();
    // Rows of at most four, as even as can be.
    let columns =
        args.columns.map_or_else(|| count.div_ceil(count.div_ceil(4)), |c| (c as usize).min(count));
    let lettering = Lettering::new((width as f32 / 24.0).max(12.0), args.background);
    let line = lettering.line_height();
    let below = if args.no_labels { 0 } else { LINES * line + line / 2 };
    let legend = if heat.is_some() && !args.no_labels { 3 * line } else { 0 };
    let rows = count.div_ceil(columns) * (height + below);
    let (across, down) = (columns * width, rows + legend);
    if (across as u64) * (down as u64) > MAX_PIXELS {
        let message = format!(
            "a contact sheet of {across} x {down} pixels is too large: use a smaller --size"
        );
        return Err(Failure::new(Status::Limit, message));
    }
    let mut sheet = Image::filled(across as u32, down as u32, args.background);
    for (i, (picture, cell)) in pictures.iter().zip(cells).enumerate() {
        let (x, y) = (i % columns * width, i / columns * (height + below));
        put(&mut sheet, picture, x, y);
        if !args.no_labels {
            for (number, text) in cell.label().iter().enumerate() {
                let place = Line { left: x, width, top: y + height + number * line };
                lettering.write(&mut sheet, text, place);
            }
        }
    }
    if let Some(heat) = heat.filter(|_| legend > 0) {
        write_legend(&mut sheet, heat, rows, &lettering);
    }
    Ok(sheet)
}

fn put(sheet: &mut Image, picture: &Image, x: usize, y: usize) {
    let row = 4 * picture.width as usize;
    for (i, from) in picture.bytes.chunks_exact(row).enumerate() {
        let start = 4 * ((y + i) * sheet.width as usize + x);
        sheet.bytes[start..start + row].copy_from_slice(from);
    }
}

/// The meaning of a heat map's colours: a bar, and the distances at its ends.
fn write_legend(sheet: &mut Image, heat: &Heat, top: usize, lettering: &Lettering) {
    let across = sheet.width as usize;
    let length = (across * 3 / 5).clamp(1, 800);
    let left = (across - length) / 2;
    let line = lettering.line_height();
    for row in top + line / 3..top + line {
        for i in 0..length {
            let [r, g, b] = colours::heat(i as f64 / length.max(2) as f64);
            let start = 4 * (row * across + left + i);
            sheet.bytes[start..start + 4].copy_from_slice(&[r, g, b, 255]);
        }
    }
    let share = if heat.diagonal > 0.0 { heat.largest / heat.diagonal * 100.0 } else { 0.0 };
    let text = format!("distance 0 to {} ({share:.3} % of the diagonal)", distance(heat.largest));
    lettering.write(sheet, &text, Line { left: 0, width: across, top: top + line + line / 4 });
}
