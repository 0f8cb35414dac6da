//! Embeds the images of the document, or renames them as their copies are called.

use crate::assets::{is_of_another_machine, last_part};
use crate::gltf::json::{Json, Object, object};
use crate::gltf::{uri, views};
use crate::images::{ImagePlace, PlacedTextures};
use crate::{Document, FormatError, GltfDocument, Limits};
use std::collections::BTreeMap;

/// Puts the images that have a place inside into a document; returns whether it can hold any, which
/// the materials of an OBJ or PLY cannot.
///
/// # Errors
/// If the document is damaged.
pub fn embed_images(
    document: &mut Document,
    textures: &PlacedTextures,
) -> Result<bool, FormatError> {
    let Document::Gltf(document) = document else { return Ok(false) };
    let (mut root, mut blob) = (document.root(&Limits::DEFAULT)?.clone(), document.blob().to_vec());
    put(&mut root, &mut blob, textures);
    if blob.len() > document.blob().len() {
        if root.list("buffers").is_empty() {
            root["buffers"] = [object! {}].into();
        }
        if let Some(buffer) = root.objects_mut("buffers").next() {
            buffer["byteLength"] = blob.len().into();
        }
        *document = GltfDocument::new(root.to_string(), blob);
    }
    Ok(true)
}

/// Makes every image refer to its bytes or its file. Embedded ones get a buffer view each, whose
/// bytes are appended to `blob` at a multiple of four; a file that is named twice is embedded once.
pub(super) fn put(root: &mut Object, blob: &mut Vec<u8>, textures: &PlacedTextures) {
    let first = root.list("bufferViews").len();
    let mut added: Vec<Json> = Vec::new();
    let mut embedded: BTreeMap<String, usize> = BTreeMap::new();
    for image in root.objects_mut("images") {
        let path = image["uri"].as_str().and_then(uri::path);
        let Some(path) = path else { continue };
        match textures.of(&path) {
            Some(ImagePlace::Beside(relative)) if *relative != path => {
                image["uri"] = uri::of_path(relative).into();
            }
            None if is_of_another_machine(&path) => {
                image["uri"] = uri::of_path(last_part(&path)).into();
            }
            None | Some(ImagePlace::Beside(_)) => {}
            Some(ImagePlace::Inside { mime, bytes }) => {
                let view = *embedded.entry(path).or_insert_with(|| {
                    added.push(views::put(blob, bytes));
                    first + added.len() - 1
                });
                image.shift_remove("uri");
                image["bufferView"] = view.into();
                image["mimeType"] = (*mime).into();
            }
        }
    }
    root.append("bufferViews", added);
}
