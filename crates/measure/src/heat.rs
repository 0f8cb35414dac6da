//! A sheet of pictures: A, B, and how far each place of A is from B, from four sides.

use crate::colours::heat;
use lodc_formats::picture::png;
use lodc_measure::{Looks, Picture, Surface, TriangleTree, Viewing, pictures};
use lodc_scene::Image;
use rayon::prelude::*;

/// Pictures side by side, and pixels across each.
const VIEWING: Viewing = Viewing { views: 4, size: 320 };

/// The PNG. `hottest` is the distance that is drawn brightest.
pub(super) fn draw(a: &Surface, b: &Surface, looks: Looks, hottest: f64) -> Vec<u8> {
    let cameras = VIEWING.cameras(a);
    let (of_a, of_b) = (pictures(a, &cameras, looks), pictures(b, &cameras, looks));
    let tree = b.tree();
    let heat: Vec<Vec<[u8; 3]>> =
        of_a.par_iter().map(|picture| distances(picture, &tree, hottest)).collect();
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
    png(&Image {
        width: VIEWING.size * VIEWING.views,
        height: VIEWING.size * rows.len() as u32,
        bytes: rgba,
    })
}

/// Colours by distance; black where nothing is.
fn distances(picture: &Picture, tree: &TriangleTree, hottest: f64) -> Vec<[u8; 3]> {
    let color = |distance_squared: f64| {
        let share = if hottest > 0.0 { distance_squared.sqrt() / hottest } else { 0.0 };
        // The root shows small differences, too.
        heat(share.sqrt())
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
