//! Heat maps: pictures of a surface coloured by the distance of each pixel's point from another
//! one.

use crate::colours::heat;
use crate::picture::{Picture, ShadingOptions, Viewing, pictures};
use crate::surface::Surface;
use lodc_nearest::TriangleTree;
use lodc_scene::Image;
use rayon::prelude::*;

/// Four pictures side by side, 320 pixels across each. Chosen by hand.
const VIEWING: Viewing = Viewing { views: 4, size: 320 };

impl Picture {
    /// Distance of each pixel's point from a surface, row by row from the top; 0 where nothing is
    /// shown.
    #[must_use]
    pub fn distances(&self, tree: &TriangleTree) -> Vec<f64> {
        let distance_of = |(colour, &point): (&[f32; 3], &_)| match colour[0] < 0.0 {
            true => 0.0,
            false => tree.distance_squared(point).sqrt(),
        };
        self.colours.iter().zip(&self.points).map(distance_of).collect()
    }

    /// An image of the picture: `colour` gets the number and the colour of each pixel, row by row
    /// from the top; pixels that show nothing are `background`.
    #[must_use]
    pub fn image(&self, background: [u8; 4], colour: impl Fn(usize, [f32; 3]) -> [u8; 3]) -> Image {
        let pixel = |(i, &shaded): (usize, &[f32; 3])| {
            if shaded[0] < 0.0 {
                return background;
            }
            let [r, g, b] = colour(i, shaded);
            [r, g, b, 255]
        };
        let bytes = self.colours.iter().enumerate().flat_map(pixel).collect();
        Image { width: self.size, height: self.size, bytes }
    }
}

/// A sheet of pictures from four sides: `a`, `b`, and `a` coloured by the distance of each point
/// from `b`. `hottest` is the distance of the reddest colour.
#[must_use]
pub fn heat_sheet(a: &Surface, b: &Surface, shading: ShadingOptions, hottest: f64) -> Image {
    const BLACK: [u8; 4] = [0, 0, 0, 255];
    let cameras = VIEWING.cameras(a);
    let [pictures_a, pictures_b] = [a, b].map(|surface| pictures(surface, &cameras, shading));
    let tree = b.tree();
    let heat_map = |picture: &Picture| {
        let distances = picture.distances(&tree);
        // The root makes small differences visible.
        let share = |i: usize| if hottest > 0.0 { (distances[i] / hottest).sqrt() } else { 0.0 };
        picture.image(BLACK, |i, _| heat(share(i)))
    };
    let plain = |p: &Picture| p.image(BLACK, |_, colour| colour.map(|v| v as u8));
    let rows: [Vec<Image>; 3] = [
        pictures_a.iter().map(plain).collect(),
        pictures_b.iter().map(plain).collect(),
        pictures_a.par_iter().map(heat_map).collect(),
    ];
    let stride = 4 * VIEWING.size as usize;
    let lines = rows.iter().flat_map(|row| {
        (0..VIEWING.size as usize)
            .flat_map(move |y| row.iter().map(move |image| &image.bytes[y * stride..][..stride]))
    });
    Image {
        width: VIEWING.size * VIEWING.views,
        height: VIEWING.size * rows.len() as u32,
        bytes: lines.flatten().copied().collect(),
    }
}
