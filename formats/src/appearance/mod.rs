//! What a scene looks like: base colours and textures of its submeshes, and where its nodes stand.
//! For pictures only; nothing here is needed to simplify or to write a scene again.

mod gltf;
mod gltf_material;
mod mtl;
mod pictures;
mod placement;
#[cfg(test)]
mod tests;

pub use crate::picture::Picture;
use crate::{Assets, Document, FormatError, ObjectInfo};

/// Everything about a scene that a picture needs besides its triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// The first one is for submeshes without a material.
    pub materials: Vec<Material>,
    /// For every object and submesh, its material.
    pub of_submesh: Vec<Vec<usize>>,
    /// Textures that materials use.
    pub pictures: Vec<Picture>,
    /// Where objects are shown; one may be shown many times or not at all.
    pub placements: Vec<Placement>,
    /// Pictures that could not be had: one line each.
    pub warnings: Vec<String>,
}

/// A material as far as its base colour goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Linear colour and opacity.
    pub colour: [f32; 4],
    /// The texture multiplied with it.
    pub texture: Option<TextureUse>,
    /// Whether triangles that turn their back are shown.
    pub double_sided: bool,
    /// What opacity means.
    pub opacity: Opacity,
    /// Whether light does not matter.
    pub unlit: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            colour: [1.0; 4],
            texture: None,
            double_sided: false,
            opacity: Opacity::Ignored,
            unlit: false,
        }
    }
}

/// What a material's opacity means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Opacity {
    /// Nothing.
    #[default]
    Ignored,
    /// There is nothing where it is below this.
    CutOff(f32),
    /// What is behind shines through.
    Blended,
}

/// How a material uses a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Index of the picture.
    pub picture: usize,
    /// Set of texture coordinates.
    pub set: u32,
    /// From the mesh's texture coordinates to the picture's, whose first row is at 0: two rows of
    /// factors and a shift.
    pub transform: [[f32; 3]; 2],
    /// What is beyond the edges, across and down.
    pub wrap: [Wrap; 2],
    /// Whether texels stay visible as squares near by.
    pub nearest: bool,
}

/// How a texture goes on beyond an edge.
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

/// An object where a scene shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Index of the object.
    pub object: usize,
    /// From the object's space to the scene's, column by column. Where there are joints, they say
    /// it instead.
    pub matrix: [f64; 16],
    /// The matrix of every joint at rest, if the object is skinned.
    pub joints: Vec<[f64; 16]>,
    /// How much of each morph target is in it.
    pub weights: Vec<f64>,
}

/// Reads what a scene looks like. Pictures are read from where `assets` has its main file; one that
/// cannot be had is a warning.
///
/// # Errors
/// If the stored document is damaged, or instances together are too many.
pub fn appearance(
    document: &Document,
    objects: &[&ObjectInfo],
    assets: &mut Assets,
) -> Result<Appearance, FormatError> {
    match document {
        Document::Obj(obj) => Ok(mtl::appearance(obj, objects, assets)),
        Document::Gltf(document) => gltf::appearance(document, objects, assets),
    }
}
