//! Images of other files become part of the document's own buffer.

use crate::import::gltf::json::Object;
use crate::import::gltf::uri;
use crate::{Assets, FormatError};
use serde_json::{Value, json};

/// Puts the images that the document refers to by URI behind `blob`. Returns a warning for each
/// that cannot be read; a texture without an image is drawn without it.
pub(super) fn embed_images(
    root: &mut Object,
    blob: &mut Vec<u8>,
    assets: &mut Assets,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut views = Vec::new();
    let first = root.get("bufferViews").and_then(Value::as_array).map_or(0, Vec::len);
    let images = root.get_mut("images").and_then(Value::as_array_mut);
    for image in images.into_iter().flatten().filter_map(Value::as_object_mut) {
        let Some(name) = image.get("uri").and_then(Value::as_str).map(str::to_owned) else {
            continue;
        };
        let read = uri::read(&name, "", assets).and_then(|bytes| match mime_type(&bytes) {
            Some(mime) => Ok((bytes, mime)),
            None => Err(unknown_kind()),
        });
        image.shift_remove("uri");
        match read {
            Ok((bytes, mime)) => {
                blob.resize(blob.len().next_multiple_of(4), 0);
                image.insert("bufferView".to_owned(), (first + views.len()).into());
                image.insert("mimeType".to_owned(), mime.into());
                views.push(json!({
                    "buffer": 0, "byteOffset": blob.len(), "byteLength": bytes.len()
                }));
                blob.extend(bytes);
            }
            Err(e) => warnings.push(format!("shown without a texture: {}", e.in_file(&name))),
        }
    }
    if !views.is_empty()
        && let Value::Array(all) = root.entry("bufferViews").or_insert_with(|| json!([]))
    {
        all.extend(views);
    }
    warnings
}

fn unknown_kind() -> FormatError {
    let what = "is no picture that browsers show (PNG, JPEG, WebP)";
    FormatError::new(crate::Fault::Unsupported, "", what)
}

/// The type of a picture by its first bytes.
fn mime_type(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, 0xff, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        _ => None,
    }
}
