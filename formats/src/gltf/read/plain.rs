//! One self-contained GLB of a document and all files that it refers to, buffer views decompressed:
//! for other readers, which get no access to files.

use super::open;
use crate::gltf::budget::Budget;
use crate::gltf::extensions::{self, MESHOPT};
use crate::gltf::json::{Json, object};
use crate::gltf::views::{self, Views};
use crate::gltf::{glb, uri};
use crate::images::kind;
use crate::options::ImportOptions;
use crate::{Assets, FormatError};

/// Makes the GLB, and a warning for each image that cannot be read.
///
/// # Errors
/// As of an import.
pub(crate) fn plain(
    bytes: &[u8],
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<(Vec<u8>, Vec<String>), FormatError> {
    let (mut root, opened) = open(bytes, assets, options)?;
    let mut warnings = opened.warnings;
    let budget = Budget::new(opened.bytes);
    let views = Views::new(&root, &opened.buffers, &budget)?;
    let mut blob = Vec::new();
    for (i, view) in root.objects_mut("bufferViews").enumerate() {
        let new_view = views::put(&mut blob, views.bytes(i)?);
        for key in ["buffer", "byteOffset", "byteLength"] {
            view[key] = new_view[key].clone();
        }
        MESHOPT.iter().for_each(|name| view.remove_extension(name));
    }
    MESHOPT.iter().for_each(|name| extensions::forget(&mut root, name));
    let first = root.list("bufferViews").len();
    let mut added: Vec<Json> = Vec::new();
    for (i, image) in root.objects_mut("images").enumerate() {
        let Some(text) = image["uri"].as_str().map(str::to_owned) else { continue };
        // The readers could not open it, so without its bytes the name is of no use.
        image.shift_remove("uri");
        match uri::read(&text, &format!("images[{i}]"), assets) {
            Ok(bytes) => {
                image["bufferView"] = (first + added.len()).into();
                image["mimeType"] = kind(&bytes).map_or("image/png", |(mime, _)| mime).into();
                added.push(views::put(&mut blob, &bytes));
            }
            Err(error) => warnings.push(format!("texture left out: {error}")),
        }
    }
    root.append("bufferViews", added);
    root["buffers"] = [object! { "byteLength" => blob.len() }].into();
    Ok((glb::joined(root.to_string().into_bytes(), &blob)?, warnings))
}
