//! The image files that a document names, and the images that it holds.

use super::document::Stored;
use super::uri;
use crate::images::{Textures, embedded_name};
use crate::{Assets, FormatError, GltfDocument, Limits};

/// Reads the image files that a document names.
///
/// # Errors
/// If the document is damaged.
pub(crate) fn read_textures(
    document: &GltfDocument,
    textures: &mut Textures,
    assets: &mut Assets,
) -> Result<(), FormatError> {
    let root = document.root(assets.limits())?;
    for (i, image) in root.entries("images").enumerate() {
        let Some(text) = image["uri"].as_str() else { continue };
        let Some(path) = uri::path(text) else { continue };
        let location = format!("images[{i}]");
        textures.add(&path, |assets| uri::read(text, &location, assets), assets);
    }
    Ok(())
}

/// The paths of the image files that a document names.
///
/// # Errors
/// If the document is damaged.
pub(crate) fn image_names(document: &GltfDocument) -> Result<Vec<String>, FormatError> {
    let root = document.root(&Limits::DEFAULT)?;
    let uris = root.entries("images").filter_map(|image| image["uri"].as_str());
    Ok(uris.filter_map(uri::path).collect())
}

/// Adds the images that a document holds itself.
///
/// # Errors
/// If the document is damaged.
pub(crate) fn add_embedded(
    document: &GltfDocument,
    textures: &mut Textures,
) -> Result<(), FormatError> {
    Stored::read(document, &Limits::DEFAULT, |stored, root| {
        for (i, image) in root.entries("images").enumerate() {
            let data = image["uri"].as_str().and_then(uri::decoded_data);
            let bytes = match (data, image["bufferView"].as_index()) {
                (Some((_, bytes)), _) => bytes,
                (None, Some(view)) => stored.view(view)?,
                (None, None) => continue,
            };
            textures.files.insert(embedded_name(i), bytes);
        }
        Ok(())
    })
}
