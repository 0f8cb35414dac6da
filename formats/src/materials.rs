//! The materials of a scene of any format: names, base colours, and the images that they show, by
//! name. Nothing is opened.

use crate::obj::mtl;
use crate::{Document, FormatError, Limits, ObjDocument, ObjectInfo, gltf};

/// The materials of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    /// All of them, in the order of the document.
    pub list: Vec<Material>,
    /// For every object and submesh the number of its material; none if it has none.
    pub of_submesh: Vec<Vec<Option<usize>>>,
}

/// A material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name; empty if it has none.
    pub name: String,
    /// Linear red, green and blue, and opacity, from 0 to 1.
    pub colour: [f32; 4],
    /// The textures that it shows.
    pub textures: Vec<MaterialTexture>,
}

impl Material {
    /// The image of the base colour, as [`MaterialTexture::image`].
    #[must_use]
    pub fn base_image(&self) -> Option<&str> {
        let is_base = |t: &&MaterialTexture| {
            t.role == "baseColorTexture" || t.role.eq_ignore_ascii_case("map_Kd")
        };
        self.textures.iter().find(is_base).map(|t| &*t.image)
    }
}

/// A texture of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialTexture {
    /// What it is for, as the format calls it: `baseColorTexture`, `normalTexture`, `map_Kd`, ….
    pub role: String,
    /// The path of its image as the document names it. An image inside the file has its name, or
    /// `image0`, `image1`, … without one.
    pub image: String,
}

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
mod tests {
    use super::*;
    use crate::import::{ImportOptions, import_bytes};

    fn materials_of(text: String) -> Materials {
        let scene = import_bytes(text.into_bytes(), &ImportOptions::default()).expect("a mesh");
        let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|o| &o.info).collect();
        materials(&scene.document, &infos, &Limits::DEFAULT).expect("a sound document")
    }

    #[test]
    fn those_of_a_gltf_have_names_colours_and_images() {
        let positions = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
        // One triangle, three times: of each material, and of none.
        let text = r#"{ "asset": { "version": "2.0" }, "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [
                { "attributes": { "POSITION": 0 }, "material": 1 },
                { "attributes": { "POSITION": 0 } },
                { "attributes": { "POSITION": 0 }, "material": 0 }] }],
            "materials": [{ "name": "oak", "normalTexture": { "index": 1 },
                "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 0, 1],
                    "baseColorTexture": { "index": 0 } } }, {}],
            "textures": [{ "source": 0 }, { "source": 1 }],
            "images": [{ "uri": "images/oak%20wood.png" },
                { "bufferView": 0, "mimeType": "image/png" }],
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "buffers": [{ "byteLength": 36, "uri": "DATA" }] }"#
            .replace("DATA", &format!("data:application/octet-stream;base64,{positions}"));
        let Materials { list, of_submesh } = materials_of(text);
        assert_eq!(of_submesh, [[Some(1), None, Some(0)]]);
        assert_eq!((&*list[0].name, list[0].colour), ("oak", [0.5, 0.25, 0.0, 1.0]));
        assert_eq!(list[0].base_image(), Some("images/oak wood.png"));
        let textures: Vec<_> = list[0].textures.iter().map(|t| (&*t.role, &*t.image)).collect();
        let base = ("baseColorTexture", "images/oak wood.png");
        assert_eq!(textures, [base, ("normalTexture", "image1")]);
        assert_eq!((&*list[1].name, list[1].colour, list[1].base_image()), ("", [1.0; 4], None));
    }

    #[test]
    fn those_of_an_obj_are_found_by_name() {
        let lines = ["Kd 1 0 0", "map_Kd -s 2 2 wood\\oak.png", "d 0.5"];
        let lines = lines.map(str::to_owned).to_vec();
        let material = crate::ObjMaterial { name: "oak".to_owned(), lines };
        let document = ObjDocument { materials: vec![material], ..ObjDocument::default() };
        let submesh = |material: Option<&str>| crate::SubmeshInfo {
            name: String::new(),
            material: material.map(str::to_owned),
            document_primitive: 0,
        };
        let info = ObjectInfo {
            name: String::new(),
            submeshes: vec![submesh(Some("oak")), submesh(Some("ash")), submesh(None)],
            world_scale: 1.0,
            document_mesh: 0,
            poses: Vec::new(),
        };
        let document = Document::Obj(document);
        let Materials { list, of_submesh } =
            materials(&document, &[&info], &Limits::DEFAULT).expect("a sound document");
        assert_eq!(of_submesh, [[Some(0), None, None]]);
        assert_eq!(list[0].colour, [1.0, 0.0, 0.0, 0.5]);
        assert_eq!(list[0].base_image(), Some("wood/oak.png"));
    }
}
