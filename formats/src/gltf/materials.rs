//! What materials of a glTF have in common with those of an MTL.

use super::json::{Object, entries, list, parse};
use super::uri;
use crate::gltf::json::as_index;
use crate::images::{Place, PlacedTextures, embedded_name};
use crate::obj::write::{Library, SimpleMaterial};
use crate::{FormatError, GltfDocument, Limits};
use serde_json::Value;

/// The materials of a document as a library, for an OBJ.
///
/// # Errors
/// If the document is damaged.
pub(crate) fn library(
    document: &GltfDocument,
    textures: &PlacedTextures,
) -> Result<Library, FormatError> {
    let root = parse(document.json.as_bytes(), &Limits::DEFAULT)?;
    let mut library = Library::default();
    for material in entries(&root, "materials") {
        let pbr = material.get("pbrMetallicRoughness").unwrap_or(&Value::Null);
        let factor: [f64; 4] =
            std::array::from_fn(|k| pbr["baseColorFactor"][k].as_f64().unwrap_or(1.0));
        let [r, g, b, opacity] = factor;
        let blended = material.get("alphaMode").and_then(Value::as_str) == Some("BLEND");
        let texture = as_index(&pbr["baseColorTexture"]["index"]);
        let texture = texture.and_then(|t| list(&root, "textures").get(t));
        let image = texture.and_then(|t| as_index(&t["source"]));
        library.add(&SimpleMaterial {
            name: material.get("name").and_then(Value::as_str).unwrap_or_default(),
            colour: [r, g, b],
            opacity: blended.then_some(opacity),
            texture: image.and_then(|i| image_file(&root, i, textures)),
        });
    }
    for (m, mesh) in entries(&root, "meshes").enumerate() {
        for (p, primitive) in list(mesh, "primitives").iter().enumerate() {
            if let Some(material) = as_index(&primitive["material"]) {
                library.assign(m, p, material);
            }
        }
    }
    Ok(library)
}

/// The file of an image; none if it has none.
fn image_file(root: &Object, image: usize, textures: &PlacedTextures) -> Option<String> {
    let path = list(root, "images").get(image)?["uri"].as_str().and_then(uri::path);
    let name = path.clone().unwrap_or_else(|| embedded_name(image));
    match textures.of(&name) {
        Some(Place::Beside(relative)) => Some(relative.clone()),
        _ => path,
    }
}
