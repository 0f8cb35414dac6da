//! The looks of a stored glTF document.

use super::gltf_material::Reader;
use super::pictures::Pictures;
use crate::import::gltf::stored::Stored;
use crate::nodes::as_index;
use crate::{Assets, FormatError, GltfDocument, ObjectInfo};
use lodc_scene::{Appearance, Material};
use serde_json::Value;

/// Linear colour of a mesh without a material. glTF says white, which leaves no room for light.
const PLAIN: [f32; 4] = [0.6, 0.6, 0.6, 1.0];

pub(super) fn appearance(
    document: &GltfDocument,
    objects: &[&ObjectInfo],
    assets: &mut Assets,
) -> Result<Appearance, FormatError> {
    let limits = *assets.limits();
    Stored::read(document, &limits, |stored, root| {
        let json = &Value::Object(root.clone());
        let number = |object: &ObjectInfo, primitive: u32| {
            let mesh = &json["meshes"][object.document_mesh as usize];
            as_index(&mesh["primitives"][primitive as usize]["material"]).map_or(0, |m| m + 1)
        };
        let of = |o: &&ObjectInfo| -> Vec<usize> {
            o.submeshes.iter().map(|s| number(o, s.document_primitive)).collect()
        };
        let of_submesh: Vec<Vec<usize>> = objects.iter().map(of).collect();
        let view = |index| stored.view(index);
        let mut reader = Reader { json, pictures: Pictures::default(), assets, view: &view };
        let mut materials = vec![Material { colour: PLAIN, ..Material::default() }];
        for (number, source) in (1..).zip(json["materials"].as_array().into_iter().flatten()) {
            // What nothing uses need not have its pictures read.
            let used = of_submesh.iter().flatten().any(|&m| m == number);
            materials.push(if used { reader.material(source) } else { Material::default() });
        }
        let Pictures { list, warnings, .. } = reader.pictures;
        Ok(Appearance { materials, of_submesh, images: list, warnings })
    })
}
