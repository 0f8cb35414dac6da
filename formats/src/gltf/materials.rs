//! What materials of a glTF have in common with those of an MTL.

use super::json::{Object, parse};
use super::uri;
use crate::images::{ImagePlace, PlacedTextures, embedded_name};
use crate::obj::write::{Library, SimpleMaterial};
use crate::{FormatError, GltfDocument, Limits};

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
    for material in root.entries("materials") {
        let pbr = &material["pbrMetallicRoughness"];
        let factor: [f64; 4] =
            std::array::from_fn(|k| pbr["baseColorFactor"][k].as_f64().unwrap_or(1.0));
        let [r, g, b, opacity] = factor;
        let blended = material["alphaMode"].as_str() == Some("BLEND");
        let texture = pbr["baseColorTexture"]["index"].as_index();
        let texture = texture.and_then(|t| root.list("textures").get(t));
        let image = texture.and_then(|t| t["source"].as_index());
        library.add(&SimpleMaterial {
            name: material["name"].as_str().unwrap_or_default(),
            colour: [r, g, b],
            opacity: blended.then_some(opacity),
            texture: image.and_then(|i| image_file(&root, i, textures)),
        });
    }
    for (m, mesh) in root.entries("meshes").enumerate() {
        for (p, primitive) in mesh.list("primitives").iter().enumerate() {
            if let Some(material) = primitive["material"].as_index() {
                library.assign(m, p, material);
            }
        }
    }
    Ok(library)
}

/// The file of an image; none if it has none.
fn image_file(root: &Object, image: usize, textures: &PlacedTextures) -> Option<String> {
    let path = root.list("images").get(image)?["uri"].as_str().and_then(uri::path);
    let name = path.clone().unwrap_or_else(|| embedded_name(image));
    match textures.of(&name) {
        Some(ImagePlace::Beside(relative)) => Some(relative.clone()),
        _ => path,
    }
}
