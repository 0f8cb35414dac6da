//! Materials, reduced to their base colour: colour, texture, opacity (glTF 2.0, 3.9).

use crate::image::Image;

/// What a scene looks like, besides its triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// All materials; the first one is for submeshes without a material.
    pub materials: Vec<Material>,
    /// Index of the material that takes the first one's place where vertices have colours, so that
    /// these alone are seen.
    pub painted: Option<usize>,
    /// For every object and submesh the index of its material.
    pub of_submesh: Vec<Vec<usize>>,
    /// The images of the materials' textures.
    pub images: Vec<Image>,
    /// A line for each image that could not be loaded.
    pub warnings: Vec<String>,
}

impl Appearance {
    /// The material of a submesh, of which the vertices have colours or not.
    #[must_use]
    pub fn material_of(&self, object: usize, submesh: usize, has_colours: bool) -> usize {
        match self.of_submesh[object][submesh] {
            0 if has_colours => self.painted.unwrap_or(0),
            material => material,
        }
    }
}

/// A material, reduced to its base colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Linear red, green and blue, and opacity; 0 to 1.
    pub colour: [f32; 4],
    /// The texture by which the colour is multiplied.
    pub texture: Option<Texture>,
    /// The texture coordinates of its textures, whether their images could be loaded or not.
    pub coordinates: Coordinates,
    /// True if triangles are shown from behind too.
    pub double_sided: bool,
    /// The meaning of opacity.
    pub alpha: AlphaMode,
    /// True if the colour is shown as it is, without lighting.
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
    /// From these coordinates to an image's, as in [`Texture::transform`].
    pub transform: [[f32; 3]; 2],
}

impl Coordinates {
    /// The first set, not transformed.
    pub const PLAIN: Self = Self { set: 0, transform: Texture::UNTRANSFORMED };

    /// Returns the image's coordinates at texture coordinates of the mesh.
    #[must_use]
    pub fn to_image(&self, [u, v]: [f32; 2]) -> [f32; 2] {
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
    /// From the mesh's texture coordinates (u, v) to the image's, across and down from its first
    /// row: for each a factor of u, a factor of v and a shift.
    pub transform: [[f32; 3]; 2],
    /// Continuation beyond the image's edges, across and down.
    pub wrap: [Wrap; 2],
    /// True if magnified texels stay squares (nearest filtering); else they are interpolated.
    pub nearest: bool,
}

impl Texture {
    /// Texture coordinates that stay as they are.
    pub const UNTRANSFORMED: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    /// Returns the image's coordinates at texture coordinates of the mesh.
    #[must_use]
    pub fn to_image(&self, [u, v]: [f32; 2]) -> [f32; 2] {
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
