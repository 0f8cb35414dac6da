//! Textures for pictures: an image and its halved sizes (mipmaps), sampled linearly between texels
//! and between sizes.

use glam::{Vec2, Vec3};
use lodc_mesh::floor;
use lodc_scene::{Image, Texture, Wrap};

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

    /// Pixels of the whole image, across and down.
    #[must_use]
    pub fn size(&self) -> Vec2 {
        Vec2::new(self.levels[0].width as f32, self.levels[0].height as f32)
    }

    /// Returns the colour at texture coordinates, sRGB values from 0 to 1, for a pixel of a picture
    /// that covers an area of `texels` texels. Linear between texels and between sizes.
    #[must_use]
    pub fn at(&self, uv: Vec2, texels: f32, wrap: [Wrap; 2]) -> Vec3 {
        let (level, share) = self.level(texels);
        let finer = bilinear(&self.levels[level], uv, wrap);
        match self.levels.get(level + 1) {
            Some(next) if share > 0.0 => finer.lerp(bilinear(next, uv, wrap), share),
            _ => finer,
        }
    }

    /// Returns linear light and opacity at coordinates of the image, as a texture has it read, for
    /// a pixel that covers an area of `texels` texels. `linear` is the light of every value.
    #[must_use]
    pub fn light(&self, uv: Vec2, texels: f32, texture: &Texture, linear: &[f32; 256]) -> [f32; 4] {
        let value = |texel: &[u8]| -> [f32; 4] {
            let table = |c: usize| if c < 3 { linear } else { &SHARES };
            std::array::from_fn(|c| table(c)[usize::from(texel[c])])
        };
        let mix = |a: [f32; 4], b: [f32; 4], share: f32| -> [f32; 4] {
            std::array::from_fn(|c| a[c] + (b[c] - a[c]) * share)
        };
        let at = |image: &Image| {
            let (texels, [x, y]) = corner_texels(image, uv, texture.wrap);
            let [a, b, c, d] = texels.map(value);
            mix(mix(a, b, x), mix(c, d, x), y)
        };
        if texture.nearest && texels <= 1.0 {
            let (texels, [x, y]) = corner_texels(&self.levels[0], uv, texture.wrap);
            return value(texels[usize::from(x >= 0.5) + 2 * usize::from(y >= 0.5)]);
        }
        let (level, share) = self.level(texels);
        let finer = at(&self.levels[level]);
        match self.levels.get(level + 1) {
            Some(next) if share > 0.0 => mix(finer, at(next), share),
            _ => finer,
        }
    }

    /// The level whose pixels are not larger than `texels` texels, and how far it is from there to
    /// the next.
    fn level(&self, mut texels: f32) -> (usize, f32) {
        let mut level = 0;
        while texels > 4.0 && level + 2 < self.levels.len() {
            texels *= 0.25;
            level += 1;
        }
        (level, ((texels - 1.0) / 3.0).clamp(0.0, 1.0))
    }
}

/// The four texels around coordinates, row by row, and how far these are from the first to the
/// last, across and down.
#[inline]
fn corner_texels(image: &Image, uv: Vec2, wrap: [Wrap; 2]) -> ([&[u8]; 4], [f32; 2]) {
    let x = axis_texels(uv.x, image.width, wrap[0]);
    let y = axis_texels(uv.y, image.height, wrap[1]);
    let texel = |i: usize, j: usize| {
        let start = 4 * (y.0[j] as usize * image.width as usize + x.0[i] as usize);
        &image.bytes[start..start + 4]
    };
    ([texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)], [x.1, y.1])
}

#[inline]
fn bilinear(image: &Image, uv: Vec2, wrap: [Wrap; 2]) -> Vec3 {
    let (texels, [x, y]) = corner_texels(image, uv, wrap);
    let [a, b, c, d] = texels.map(|texel| {
        Vec3::new(SHARES[texel[0] as usize], SHARES[texel[1] as usize], SHARES[texel[2] as usize])
    });
    a.lerp(b, x).lerp(c.lerp(d, x), y)
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
