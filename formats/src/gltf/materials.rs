//! The materials of a glTF as an MTL library, for an export as OBJ: names, base colours, opacity
//! and base colour textures, which is all that both formats have.

use super::coordinates::base_colour;
use super::json::Object;
use super::material_names::image;
use super::texture_transform::CLAMP;
use super::uri;
use crate::images::{ImagePlace, PlacedTextures, embedded_name};
use crate::obj::write::{Library, SimpleMaterial};
use crate::{FormatError, GltfDocument, Limits};
use lodc_scene::srgb_value;

/// The materials of a document as a library, for an OBJ.
///
/// # Errors
/// If the document is damaged.
pub(crate) fn library(
    document: &GltfDocument,
    textures: &PlacedTextures,
) -> Result<Library, FormatError> {
    let root = document.root(&Limits::DEFAULT)?;
    let mut library = Library::default();
    for material in root.list("materials") {
        let (factor, info) = base_colour(material);
        let [r, g, b, opacity] = factor.numbers([1.0; 4]);
        let blended = material["alphaMode"].as_str() == Some("BLEND");
        let texture = info["index"].as_index().and_then(|t| root.list("textures").get(t));
        let file = texture.and_then(|t| image_file(root, image(t)?, textures));
        let sampler = texture.and_then(|t| root.list("samplers").get(t["sampler"].as_index()?));
        let clamps = |key: &str| sampler.is_some_and(|s| s[key].as_u64() == Some(CLAMP.into()));
        library.add(&SimpleMaterial {
            name: material["name"].as_str().unwrap_or_default(),
            colour: [r, g, b].map(|light| six_decimals(srgb_value(light as f32).into())),
            opacity: blended.then_some(opacity),
            texture: file,
            clamped: clamps("wrapS") && clamps("wrapT"),
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

/// A value with six decimals: no machine's power function decides a byte of a file.
pub(super) fn six_decimals(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
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
