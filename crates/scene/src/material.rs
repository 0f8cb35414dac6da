//! Materials as far as their base colour goes: colour, texture, opacity (glTF 2.0, 3.9).

use crate::image::Image;

/// The looks of a scene, besides its triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// The first one is for submeshes without a material.
    pub materials: Vec<Material>,
    /// For every object and submesh, its material.
    pub of_submesh: Vec<Vec<usize>>,
    /// Images that textures of materials show.
    pub images: Vec<Image>,
    /// Images that could not be had: one line each.
    pub warnings: Vec<String>,
}

/// A material as far as its base colour goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Linear red, green and blue, and opacity; 0 to 1.
    pub colour: [f32; 4],
    /// The texture multiplied with it.
    pub texture: Option<Texture>,
    /// The texture coordinates that its textures read, whether their images could be had or not.
    pub coordinates: Coordinates,
    /// True if triangles that turn their back are shown.
    pub double_sided: bool,
    /// The meaning of opacity.
    pub alpha: AlphaMode,
    /// True if light does not matter.
    pub unlit: bool,
}

impl Default for Material {
    /// White, opaque, seen from the front.
    fn default() -> Self {
        Self {
            colour: [1.0; 4],
            texture: None,
            coordinates: Coordinates::PLAIN,
            double_sided: false,
            alpha: AlphaMode::Opaque,
            unlit: false,
        }
    }
}

/// The meaning of a material's opacity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// None: all is opaque.
    #[default]
    Opaque,
    /// Nothing is drawn where opacity is below this; all else is opaque.
    Mask(f32),
    /// Surfaces behind shine through.
    Blend,
}

/// Texture coordinates and their meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    /// Number of the set.
    pub set: u32,
    /// From the set to an image, as in [`Texture::transform`].
    pub transform: [[f32; 3]; 2],
}

impl Coordinates {
    /// The first set as it is.
    pub const PLAIN: Self = Self { set: 0, transform: Texture::UNTRANSFORMED };

    /// Returns the image's coordinates at texture coordinates of the mesh.
    #[must_use]
    pub fn place(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        self.transform.map(|[x, y, shift]| x * u + y * v + shift)
    }
}

/// An image on a material, and how it is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Index of the image.
    pub image: usize,
    /// Set of texture coordinates.
    pub set: u32,
    /// From the mesh's texture coordinates to the image's, whose first row is at 0: two rows of
    /// factors and a shift.
    pub transform: [[f32; 3]; 2],
    /// Continuation beyond the edges, across and down.
    pub wrap: [Wrap; 2],
    /// True if texels stay visible as squares when seen from near by.
    pub nearest: bool,
}

impl Texture {
    /// Texture coordinates that stay as they are.
    pub const UNTRANSFORMED: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    /// Returns the image's coordinates at texture coordinates of the mesh.
    #[must_use]
    pub fn place(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        self.transform.map(|[x, y, shift]| x * u + y * v + shift)
    }
}

/// The continuation of a texture beyond an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// From the start again.
    #[default]
    Repeat,
    /// Backwards.
    Mirror,
    /// With its last texels.
    Clamp,
}
