//! The materials of a glTF as an MTL library, for an export as OBJ: names, base colours, opacity
//! and base colour textures, which is all that both formats have.

use super::json::{Json, Object, parse};
use super::texture_transform::{CLAMP, texture_coordinates};
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
    let root = parse(document.json.as_bytes(), &Limits::DEFAULT)?;
    let mut library = Library::default();
    for material in root.entries("materials") {
        let pbr = &material["pbrMetallicRoughness"];
        let factor: [f64; 4] =
            std::array::from_fn(|k| pbr["baseColorFactor"][k].as_f64().unwrap_or(1.0));
        let [r, g, b, opacity] = factor;
        let blended = material["alphaMode"].as_str() == Some("BLEND");
        let info = &pbr["baseColorTexture"];
        let texture = info["index"].as_index().and_then(|t| root.list("textures").get(t));
        let image = texture.and_then(|t| t["source"].as_index());
        let file = image.and_then(|i| image_file(&root, i, textures));
        let sampler = texture.and_then(|t| root.list("samplers").get(t["sampler"].as_index()?));
        library.add(&SimpleMaterial {
            name: material["name"].as_str().unwrap_or_default(),
            colour: [r, g, b].map(|light| six_decimals(srgb_value(light as f32).into())),
            opacity: blended.then_some(opacity),
            texture: file.map(|file| format!("{}{file}", map_options(info, sampler))),
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

/// The options of `map_Kd` that show a texture as a glTF does, each with a space after it. A turned
/// texture has none that could.
fn map_options(info: &Json, sampler: Option<&Json>) -> String {
    let mut options = String::new();
    let [[su, skew, u], [turn, sv, v]] = texture_coordinates(info).transform;
    if [skew, turn] == [0.0; 2] {
        // Coordinates of an OBJ begin at the bottom of the picture, those of a glTF at the top.
        let (u, v) = (u, 1.0 - sv - v);
        if [su, sv] != [1.0; 2] {
            options += &format!("-s {su} {sv} ");
        }
        if [u, v] != [0.0; 2] {
            options += &format!("-o {u} {v} ");
        }
    }
    let clamps = |key: &str| sampler.is_some_and(|s| s[key].as_u64() == Some(CLAMP.into()));
    if clamps("wrapS") && clamps("wrapT") {
        options += "-clamp on ";
    }
    options
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
