//! The materials of a glTF document by name, with the names of their images.

use super::coordinates::base_colour;
use super::extensions::IMAGE_EXTENSIONS;
use super::json::{Json, Object};
use super::uri;
use crate::material::{Material, MaterialTexture, Materials};
use crate::{FormatError, GltfDocument, Limits, ObjectInfo};

/// Reads the materials of a document.
///
/// # Errors
/// If it is damaged.
pub(crate) fn materials(
    document: &GltfDocument,
    objects: &[&ObjectInfo],
    limits: &Limits,
) -> Result<Materials, FormatError> {
    let root = document.root(limits)?;
    let primitive = |mesh: u32, primitive: u32| {
        root.list("meshes").get(mesh as usize)?["primitives"].list().get(primitive as usize)
    };
    let count = root.list("materials").len();
    let material_of = |mesh: u32, number: u32| {
        let material = primitive(mesh, number)?["material"].as_index()?;
        (material < count).then_some(material)
    };
    let of_object = |o: &&ObjectInfo| {
        o.submeshes.iter().map(|s| material_of(o.document_mesh, s.document_primitive)).collect()
    };
    Ok(Materials {
        list: root.list("materials").iter().map(|source| material(root, source)).collect(),
        of_submesh: objects.iter().map(of_object).collect(),
    })
}

fn material(root: &Object, source: &Json) -> Material {
    let (factor, base_texture) = base_colour(source);
    let metal = &source["pbrMetallicRoughness"];
    let roles = [
        ("baseColorTexture", base_texture),
        ("metallicRoughnessTexture", &metal["metallicRoughnessTexture"]),
        ("normalTexture", &source["normalTexture"]),
        ("occlusionTexture", &source["occlusionTexture"]),
        ("emissiveTexture", &source["emissiveTexture"]),
    ];
    let texture = |(role, info): (&str, &Json)| {
        let texture = root.list("textures").get(info["index"].as_index()?)?;
        let number = image(texture)?;
        let source = root.list("images").get(number)?;
        let path = source["uri"].as_str().and_then(uri::path);
        let name = || source["name"].as_str().map(str::to_owned);
        let image = path.or_else(name).unwrap_or_else(|| format!("image{number}"));
        Some(MaterialTexture { role: role.to_owned(), image })
    };
    Material {
        name: source["name"].as_str().unwrap_or_default().to_owned(),
        colour: factor.numbers([1.0; 4]).map(|value| value as f32),
        textures: roles.into_iter().filter_map(texture).collect(),
    }
}

/// The image of a texture: the one that every reader knows, or else that of an extension.
pub(super) fn image(texture: &Json) -> Option<usize> {
    let of_extension = |name: &&str| texture["extensions"][*name]["source"].as_index();
    texture["source"].as_index().or_else(|| IMAGE_EXTENSIONS.iter().find_map(of_extension))
}
