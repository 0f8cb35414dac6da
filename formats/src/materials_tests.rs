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
