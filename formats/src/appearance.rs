//! The appearance of a scene: base colour factor and base colour texture of every submesh, read
//! from its stored glTF or MTL document, for pictures and metrics that look at colours; and the
//! texture coordinates that matter where vertices move.

use crate::{Assets, Document, FormatError, Limits, ObjectInfo, gltf, obj};
use lodc_scene::{Appearance, Coordinates};

/// Reads the materials of a scene and their images, which are looked for beside the main file of
/// `assets`; one that cannot be read is a warning.
///
/// # Errors
/// If the stored document is damaged, or its images have more pixels than the limits allow.
pub fn appearance(
    document: &Document,
    objects: &[&ObjectInfo],
    assets: &mut Assets,
) -> Result<Appearance, FormatError> {
    match document {
        Document::Obj(obj) => obj::appearance(obj, objects, assets),
        Document::Gltf(gltf) => gltf::appearance(gltf, objects, assets),
    }
}

/// Returns, for every object and submesh, the texture coordinates that its textures read. Images
/// are not opened: they do not matter.
///
/// # Errors
/// If the stored document is damaged.
pub fn coordinates(
    document: &Document,
    objects: &[&ObjectInfo],
    limits: &Limits,
) -> Result<Vec<Vec<Coordinates>>, FormatError> {
    match document {
        Document::Obj(obj) => Ok(obj::coordinates(obj, objects)),
        Document::Gltf(gltf) => gltf::coordinates(gltf, objects, limits),
    }
}

#[cfg(test)]
#[path = "appearance_tests.rs"]
mod tests;
