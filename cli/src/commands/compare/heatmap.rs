//! A sheet of pictures: A, B, and how far each place of A is from B, from four sides.

use lodc_formats::picture::{Picture as Sheet, png};
use lodc_measure::{Bvh, Looks, Picture, Surface, Viewing, pictures};
use rayon::prelude::*;

/// Pictures side by side, and pixels across each.
const VIEWING: Viewing = Viewing { views: 4, size: 320 };

/// The PNG. `hottest` is the distance that is drawn brightest.
pub(super) fn draw(a: &Surface, b: &Surface, looks: Looks, hottest: f64) -> Vec<u8> {
    let cameras = VIEWING.cameras(a);
    let (of_a, of_b) = (pictures(a, &cameras, looks), pictures(b, &cameras, looks));
    let tree = Bvh::new(b);
    let heat: Vec<Vec<[u8; 3]>> =
        of_a.par_iter().map(|picture| heat(picture, &tree, hottest)).collect();
    let seen = |p: &Picture| p.colours.iter().map(|c| c.map(|v| v.max(0.0) as u8)).collect();
    let rows: [Vec<Vec<[u8; 3]>>; 3] =
        [of_a.iter().map(seen).collect(), of_b.iter().map(seen).collect(), heat];
    let size = VIEWING.size as usize;
    let mut rgba = Vec::with_capacity(rows.len() * cameras.len() * size * size * 4);
    for row in &rows {
        for line in 0..size {
            for picture in row {
                rgba.extend(
                    picture[line * size..(line + 1) * size]
                        .iter()
                        .flat_map(|&[r, g, b]| [r, g, b, 255]),
                );
            }
        }
    }
    png(&Sheet {
        width: VIEWING.size * VIEWING.views,
        height: VIEWING.size * rows.len() as u32,
        bytes: rgba,
    })
}

/// Colours by distance: dark blue for none, through green and yellow, to red for the hottest.
fn heat(picture: &Picture, tree: &Bvh, hottest: f64) -> Vec<[u8; 3]> {
    let color = |distance_squared: f64| {
        let distance = distance_squared.sqrt();
        let heat = if hottest > 0.0 { (distance / hottest).min(1.0) } else { 0.0 };
        // The root shows small differences, too.
        let x = heat.sqrt() * 3.0;
        let part = |from: f64| ((x - from).clamp(0.0, 1.0) * 255.0) as u8;
        [part(1.0), part(0.0) - part(2.0), ((1.0 - x).clamp(0.0, 1.0) * 160.0) as u8]
    };
    let places = picture.colours.iter().zip(&picture.points);
    places
        .map(
            |(colour, &place)| {
                if colour[0] < 0.0 { [0; 3] } else { color(tree.distance_squared(place)) }
            },
        )
        .collect()
}
