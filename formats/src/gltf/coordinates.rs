//! Which texture coordinates the materials of a stored glTF read, and how they move them; and the
//! materials' base colours.

use super::document::Stored;
use super::json::{Json, Object};
use super::texture_transform::texture_coordinates;
use crate::{FormatError, GltfDocument, Limits, ObjectInfo};
use lodc_scene::Coordinates;

/// The texture coordinates that the textures of submeshes read, by object.
///
/// # Errors
/// If the document is damaged.
pub(crate) fn coordinates(
    document: &GltfDocument,
    objects: &[&ObjectInfo],
    limits: &Limits,
) -> Result<Vec<Vec<Coordinates>>, FormatError> {
    Stored::read(document, limits, |_, root| {
        let list = root.list("materials");
        let read_by = |m: &usize| match m.checked_sub(1).and_then(|m| list.get(m)) {
            Some(material) => material_coordinates(material),
            None => Coordinates::PLAIN,
        };
        let by_submesh = |materials: Vec<usize>| materials.iter().map(read_by).collect();
        Ok(materials(root, objects).into_iter().map(by_submesh).collect())
    })
}

/// For every object and submesh the number of its material plus 1, or 0 without one.
pub(super) fn materials(root: &Object, objects: &[&ObjectInfo]) -> Vec<Vec<usize>> {
    let number = |object: &ObjectInfo, primitive: u32| {
        let mesh = &root["meshes"][object.document_mesh as usize];
        mesh["primitives"][primitive as usize]["material"].as_index().map_or(0, |m| m + 1)
    };
    let numbers = |o: &&ObjectInfo| -> Vec<usize> {
        o.submeshes.iter().map(|s| number(o, s.document_primitive)).collect()
    };
    objects.iter().map(numbers).collect()
}

/// The base colour of a material, and its texture.
pub(super) fn base_colour(material: &Json) -> (&Json, &Json) {
    let glossy = &material["extensions"]["KHR_materials_pbrSpecularGlossiness"];
    let metal = &material["pbrMetallicRoughness"];
    if metal.is_object() || !glossy.is_object() {
        (&metal["baseColorFactor"], &metal["baseColorTexture"])
    } else {
        (&glossy["diffuseFactor"], &glossy["diffuseTexture"])
    }
}

/// The texture coordinates that a material's base colour texture reads; without one its first
/// texture.
pub(super) fn material_coordinates(material: &Json) -> Coordinates {
    let texture = base_colour(material).1;
    let read = if texture.is_object() { Some(texture) } else { any_texture(material) };
    read.map_or(Coordinates::PLAIN, texture_coordinates)
}

/// The first texture of a material, whatever it is for.
fn any_texture(material: &Json) -> Option<&Json> {
    material.as_object()?.iter().find_map(|(name, value)| {
        let is_texture = name.ends_with("Texture") && value["index"].as_index().is_some();
        if is_texture { Some(value) } else { any_texture(value) }
    })
}
