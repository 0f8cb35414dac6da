//! Images laid over triangles by texture coordinates, as a camera sees them.

use glam::{Vec2, Vec3};
use lodc_scene::{Image, Wrap};

/// An image that can be read at any place and size: itself and all its halves. Texture coordinates
/// 0 to 1 span it, with its first row at 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    levels: Vec<Image>,
}

impl Pyramid {
    /// The pyramid of an image. One without pixels is white.
    #[must_use]
    pub fn new(image: &Image) -> Self {
        let empty = image.width == 0 || image.height == 0;
        let image = if empty { Image::filled(1, 1, [255; 4]) } else { image.clone() };
        Self { levels: image.levels() }
    }

    /// Pixels of the whole image.
    #[must_use]
    pub fn area(&self) -> f32 {
        self.levels[0].width as f32 * self.levels[0].height as f32
    }

    /// Returns the colour at a place, sRGB values from 0 to 1, for a pixel of a picture as large
    /// as `texels` of the image. Linear between texels and between sizes.
    #[must_use]
    pub fn at(&self, place: Vec2, texels: f32, wrap: [Wrap; 2]) -> Vec3 {
        let (mut level, mut left) = (0, texels);
        while left > 4.0 && level + 2 < self.levels.len() {
            left *= 0.25;
            level += 1;
        }
        let near = bilinear(&self.levels[level], place, wrap);
        let share = ((left - 1.0) / 3.0).clamp(0.0, 1.0);
        match self.levels.get(level + 1) {
            Some(next) if share > 0.0 => near.lerp(bilinear(next, place, wrap), share),
            _ => near,
        }
    }
}

fn bilinear(image: &Image, place: Vec2, wrap: [Wrap; 2]) -> Vec3 {
    let x = along(place.x, image.width, wrap[0]);
    let y = along(place.y, image.height, wrap[1]);
    let texel = |i: usize, j: usize| {
        let [r, g, b, _] = image.at(x.0[i], y.0[j]).map(f32::from);
        Vec3::new(r, g, b) / 255.0
    };
    let row = |j: usize| texel(0, j).lerp(texel(1, j), x.1);
    row(0).lerp(row(1), y.1)
}

/// The two texels beside a place along one axis, and how far it is from the first to the second.
fn along(place: f32, size: u32, wrap: Wrap) -> ([u32; 2], f32) {
    let place = if place.is_finite() { place } else { 0.0 };
    let turns = match wrap {
        Wrap::Repeat => place - place.floor(),
        Wrap::Mirror => 2.0 * (place * 0.5 - (place * 0.5).floor()),
        Wrap::Clamp => place.clamp(0.0, 1.0),
    };
    let at = turns * size as f32 - 0.5;
    let (first, share) = (at.floor(), at - at.floor());
    let index = |i: i64| {
        let size = i64::from(size);
        (match wrap {
            Wrap::Repeat => i.rem_euclid(size),
            Wrap::Clamp => i.clamp(0, size - 1),
            Wrap::Mirror => {
                let i = i.rem_euclid(2 * size);
                i.min(2 * size - 1 - i)
            }
        }) as u32
    };
    ([index(first as i64), index(first as i64 + 1)], share)
}
