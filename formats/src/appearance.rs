//! The looks of a scene: base colours and textures of its submeshes. For pictures only;
//! nothing here is needed to simplify or to write a scene again.

use crate::{Assets, Document, FormatError, ObjectInfo, gltf, obj};
use lodc_scene::Appearance;

/// Reads the looks of a scene. Images are read from where `assets` has its main file; one that
/// cannot be had is a warning.
///
/// # Errors
/// If the stored document is damaged.
pub fn appearance(
    document: &Document,
    objects: &[&ObjectInfo],
    assets: &mut Assets,
) -> Result<Appearance, FormatError> {
    match document {
        Document::Obj(obj) => Ok(obj::appearance(obj, objects, assets)),
        Document::Gltf(gltf) => gltf::appearance(gltf, objects, assets),
    }
}

#[cfg(test)]
#[path = "appearance_tests.rs"]
mod tests;
