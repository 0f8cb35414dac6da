//! Images of the document: embedded, or under the name that their copy has.

use crate::gltf::json::Object;
use crate::gltf::uri;
use crate::images::{Place, PlacedTextures};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Gives every image its place. Embedded ones get a buffer view each, at a multiple of four bytes
/// behind what `blob` holds; an image file that is named twice is embedded once.
pub(super) fn put(root: &mut Object, blob: &mut Vec<u8>, textures: &PlacedTextures) {
    let mut views = root.get("bufferViews").and_then(Value::as_array).map_or(0, Vec::len);
    let mut added: Vec<Value> = Vec::new();
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    let images = root.get_mut("images").and_then(Value::as_array_mut).into_iter().flatten();
    for image in images.filter_map(Value::as_object_mut) {
        let path = image.get("uri").and_then(Value::as_str).and_then(uri::path);
        let Some(path) = path else { continue };
        match textures.of(&path) {
            Some(Place::Beside(relative)) if *relative != path => {
                image.insert("uri".to_owned(), uri::of_path(relative).into());
            }
            None | Some(Place::Beside(_)) => {}
            Some(Place::Inside { mime, bytes }) => {
                let view = *known.entry(path).or_insert_with(|| {
                    blob.resize(blob.len().next_multiple_of(4), 0);
                    added.push(json!({
                        "buffer": 0, "byteOffset": blob.len(), "byteLength": bytes.len()
                    }));
                    blob.extend_from_slice(bytes);
                    views += 1;
                    views - 1
                });
                image.shift_remove("uri");
                image.insert("bufferView".to_owned(), view.into());
                image.insert("mimeType".to_owned(), (*mime).into());
            }
        }
    }
    if added.is_empty() {
        return;
    }
    if let Value::Array(all) = root.entry("bufferViews").or_insert_with(|| json!([])) {
        all.extend(added);
    }
}
