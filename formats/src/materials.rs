//! Reads the materials of a scene of any format by name. Nothing is opened.

use crate::material::{Material, MaterialTexture, Materials};
use crate::obj::mtl;
use crate::{Document, FormatError, Limits, ObjDocument, ObjectInfo, gltf};

/// Reads the materials of a scene.
///
/// # Errors
/// If the stored document is damaged.
pub fn materials(
    document: &Document,
    objects: &[&ObjectInfo],
    limits: &Limits,
) -> Result<Materials, FormatError> {
    match document {
        Document::Obj(obj) => Ok(of_obj(obj, objects)),
        Document::Gltf(gltf) => gltf::materials(gltf, objects, limits),
    }
}

fn of_obj(obj: &ObjDocument, objects: &[&ObjectInfo]) -> Materials {
    let texture = |line: &String| {
        let image = mtl::file(line)?.replace('\\', "/");
        let role = line.split_whitespace().next()?.to_owned();
        Some(MaterialTexture { role, image })
    };
    let numbers = mtl::numbers(&obj.materials);
    let number = |name: &str| numbers.get(name).copied();
    let of_object = |o: &&ObjectInfo| {
        o.submeshes.iter().map(|s| s.material.as_deref().and_then(number)).collect()
    };
    Materials {
        list: obj
            .materials
            .iter()
            .map(|m| {
                let textures: Vec<_> = m.lines.iter().filter_map(texture).collect();
                let meaning = mtl::Meaning::of(m);
                let colour = meaning.base_colour(meaning.map().is_some());
                Material { name: m.name.clone(), colour, textures }
            })
            .collect(),
        of_submesh: objects.iter().map(of_object).collect(),
    }
}

#[cfg(all(test, feature = "import"))]
#[path = "materials_tests.rs"]
mod tests;
