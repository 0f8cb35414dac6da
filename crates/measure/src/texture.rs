//! Textures for pictures: an image and its halved sizes (mipmaps), sampled linearly between texels
//! and between sizes.

use glam::{Vec2, Vec3};
use lodc_mesh::floor;
use lodc_scene::{Image, Wrap};

/// An image that can be read at any coordinates and size: itself and all its halved sizes. Texture
/// coordinates 0 to 1 span it, with its first row at 0.
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

    /// Returns the colour at texture coordinates, sRGB values from 0 to 1, for a pixel of a picture
    /// that covers an area of `texels` texels. Linear between texels and between sizes.
    #[must_use]
    pub fn at(&self, uv: Vec2, texels: f32, wrap: [Wrap; 2]) -> Vec3 {
        let (mut level, mut level_texels) = (0, texels);
        while level_texels > 4.0 && level + 2 < self.levels.len() {
            level_texels *= 0.25;
            level += 1;
        }
        let finer = bilinear(&self.levels[level], uv, wrap);
        let share = ((level_texels - 1.0) / 3.0).clamp(0.0, 1.0);
        match self.levels.get(level + 1) {
            Some(next) if share > 0.0 => finer.lerp(bilinear(next, uv, wrap), share),
            _ => finer,
        }
    }
}

#[inline]
fn bilinear(image: &Image, uv: Vec2, wrap: [Wrap; 2]) -> Vec3 {
    let x = axis_texels(uv.x, image.width, wrap[0]);
    let y = axis_texels(uv.y, image.height, wrap[1]);
    let texel = |i: usize, j: usize| {
        let start = 4 * (y.0[j] as usize * image.width as usize + x.0[i] as usize);
        let texel = &image.bytes[start..start + 3];
        Vec3::new(SHARES[texel[0] as usize], SHARES[texel[1] as usize], SHARES[texel[2] as usize])
    };
    let row = |j: usize| texel(0, j).lerp(texel(1, j), x.1);
    row(0).lerp(row(1), y.1)
}

/// The values of a channel as shares of 255: a table, since millions of texels are read.
const SHARES: [f32; 256] = {
    let mut shares = [0.0; 256];
    let mut i = 0;
    while i < 256 {
        shares[i] = i as f32 / 255.0;
        i += 1;
    }
    shares
};

/// The two texels beside a coordinate along one axis, and how far it is from the first to the
/// second.
#[inline]
fn axis_texels(coordinate: f32, size: u32, wrap: Wrap) -> ([u32; 2], f32) {
    let coordinate = if coordinate.is_finite() { coordinate } else { 0.0 };
    let in_image = match wrap {
        Wrap::Repeat => coordinate - floor(coordinate),
        Wrap::Mirror => 2.0 * (coordinate * 0.5 - floor(coordinate * 0.5)),
        Wrap::Clamp => coordinate.clamp(0.0, 1.0),
    };
    let position = in_image * size as f32 - 0.5;
    let lower = floor(position);
    // Positions are at most one texel outside of the image, or of it and its mirror image.
    let (lowest, size) = (lower as i32, size as i32);
    let wrapped = |i: i32, size: i32| match i {
        _ if i < 0 => i + size,
        _ if i >= size => i - size,
        _ => i,
    };
    let index = |i: i32| {
        (match wrap {
            Wrap::Repeat => wrapped(i, size),
            Wrap::Clamp => i.clamp(0, size - 1),
            Wrap::Mirror => {
                let i = wrapped(i, 2 * size);
                i.min(2 * size - 1 - i)
            }
        }) as u32
    };
    ([index(lowest), index(lowest + 1)], position - lower)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_begin_again_at_the_ends() {
        for size in [1, 2, 5] {
            for (step, wrap) in (0..200)
                .flat_map(|step| [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp].map(|wrap| (step, wrap)))
            {
                let coordinate = (step as f32 - 100.0) * 0.037;
                let at = f64::from(coordinate) * f64::from(size) - 0.5;
                let expected = [0, 1].map(|next| {
                    let (i, size) = (at.floor() as i64 + next, i64::from(size));
                    match wrap {
                        Wrap::Repeat => i.rem_euclid(size),
                        Wrap::Clamp => i.clamp(0, size - 1),
                        Wrap::Mirror => {
                            i.rem_euclid(2 * size).min(2 * size - 1 - i.rem_euclid(2 * size))
                        }
                    }
                });
                let found = axis_texels(coordinate, size, wrap).0.map(i64::from);
                // Rounding may decide where a place is at a texel's middle.
                let is_middle = (at - at.round()).abs() < 1e-5;
                assert!(
                    is_middle || found == expected,
                    "{coordinate} of {size}: {found:?}, not {expected:?}"
                );
            }
        }
    }
}
