//! The parts of a document that stay besides its triangles.

use super::{Builder, gltf, parsed, read, read_bytes, sound};
use crate::Fault;
use crate::import::ImportOptions;
use serde_json::{Value, json};

/// A triangle, an animation and an image, in this order of accessors and views: triangle, times,
/// values, image.
fn animated() -> Value {
    let mut b = Builder::default();
    let p = b.zigzag(3);
    let times = b.floats("SCALAR", 1, &[0.0, 1.0]);
    let values = b.floats("VEC3", 3, &[0.0; 6]);
    let image = b.view(b"not really a picture");
    let mut root = b.with_meshes(
        &json!([{ "primitives": [{ "attributes": { "POSITION": p }, "material": 0 }] }]),
    );
    root["animations"] = json!([{
        "samplers": [{ "input": times, "output": values }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
    }]);
    root["images"] = json!([{ "bufferView": image, "mimeType": "image/png" }]);
    root["materials"] = json!([{ "name": "m" }]);
    root
}

#[test]
fn geometry_goes_and_the_rest_is_renumbered_and_compacted() {
    let root = animated();
    let scene = sound(&root);
    let remaining = parsed(&scene);
    assert_eq!(remaining["meshes"][0]["primitives"][0], json!({ "attributes": {}, "material": 0 }));
    assert_eq!(remaining["animations"][0]["samplers"][0], json!({ "input": 0, "output": 1 }));
    assert_eq!(remaining["images"][0]["bufferView"], json!(2));
    assert_eq!(remaining["accessors"].as_array().map(Vec::len), Some(2));
    let blob = gltf(&scene).blob();
    assert_eq!(remaining["buffers"], json!([{ "byteLength": blob.len() }]));
    let offset = remaining["bufferViews"][2]["byteOffset"].as_u64().expect("an offset") as usize;
    assert_eq!(&blob[offset..], b"not really a picture");
    assert_eq!(blob.len(), 8 + 24 + 20);
}

#[test]
fn nothing_is_renumbered_under_an_unknown_extension_with_numbers() {
    let mut root = animated();
    root["extensions"] = json!({ "X_unknown": { "accessor": 0 } });
    let scene = sound(&root);
    let remaining = parsed(&scene);
    assert_eq!(remaining["accessors"].as_array().map(Vec::len), Some(3));
    assert_eq!(remaining["images"][0]["bufferView"], json!(3));
    assert!(scene.warnings.iter().any(|w| w.contains("X_unknown")));
    // Without a whole number there is nothing that it could point with.
    root["extensions"] = json!({ "X_unknown": { "factor": 0.5, "name": "0" } });
    assert_eq!(parsed(&sound(&root))["accessors"].as_array().map(Vec::len), Some(2));
}

#[test]
fn what_nothing_names_goes_with_its_bytes() {
    let mut root = animated();
    let without = gltf(&sound(&root)).blob().len();
    let more = |root: &mut Value, pool: &str, entry: Value| {
        root[pool].as_array_mut().expect("a list").push(entry);
    };
    let position = root["accessors"][0].clone();
    more(&mut root, "accessors", position);
    let all = root["buffers"][0]["byteLength"].clone();
    more(&mut root, "bufferViews", json!({ "buffer": 0, "byteLength": all }));
    let scene = sound(&root);
    let remaining = parsed(&scene);
    assert_eq!(remaining["accessors"].as_array().map(Vec::len), Some(2));
    assert_eq!(remaining["bufferViews"].as_array().map(Vec::len), Some(3));
    assert_eq!(gltf(&scene).blob().len(), without);
    // Of what an unknown extension may name, its numbers stay, and the bytes of those that it has.
    for (number, kept) in [(4, true), (9, false)] {
        root["extensions"] = json!({ "X_unknown": { "data": number } });
        let scene = sound(&root);
        let remaining = parsed(&scene);
        assert_eq!(remaining["bufferViews"].as_array().map(Vec::len), Some(5));
        let length = remaining["bufferViews"][4]["byteLength"].clone();
        assert_eq!(length, if kept { all.clone() } else { json!(4) });
        assert!(scene.warnings.iter().any(|w| w.contains("the extension X_unknown is unknown")));
    }
}

#[test]
fn views_that_overlap_do_not_multiply() {
    let mut b = Builder::default();
    let p = b.zigzag(3);
    b.view(&[7; 1000]);
    let offset = b.views[1]["byteOffset"].as_u64().expect("an offset");
    for i in 0..200u64 {
        b.views.push(json!({ "buffer": 0, "byteOffset": offset + i, "byteLength": 800 }));
    }
    let mut root = b.with_meshes(&json!([{ "primitives": [{ "attributes": { "POSITION": p } }] }]));
    let image = |view: usize| json!({ "bufferView": view, "mimeType": "image/png" });
    root["images"] = (1..202).map(image).collect();
    let scene = sound(&root);
    assert_eq!(gltf(&scene).blob().len(), 1000);
    let remaining = parsed(&scene);
    assert_eq!(remaining["bufferViews"][200]["byteOffset"], json!(199));
}

#[test]
fn members_keep_their_order_and_numbers_their_spelling() {
    let text = concat!(
        r#"{"zebra":1.50e+3,"asset":{"version":"2.0","extras":{"b":1.0,"a":-0.0}},"#,
        r#""apple":100000000000000000000000}"#
    );
    let scene = read_bytes(text.as_bytes(), &ImportOptions::default()).expect("sound");
    let mut expected = text.to_owned();
    // The only liberty: an exponent is written one way.
    expected = expected.replace("1.50e+3", &gltf(&scene).json()[9..16]);
    assert_eq!(gltf(&scene).json(), expected);
}

#[test]
fn points_lines_and_triangles_without_area_pass_through_unchanged() {
    let mut b = Builder::default();
    let p = b.zigzag(4);
    let i = b.indices(&[0, 0, 1]);
    let lines = json!({ "attributes": { "POSITION": p }, "mode": 1 });
    let flat = json!({ "attributes": { "POSITION": p }, "indices": i });
    let solid = json!({ "attributes": { "POSITION": p }, "mode": 5 });
    let root =
        b.with_meshes(&json!([{ "primitives": [lines, flat, solid] }, { "primitives": [flat] }]));
    let scene = sound(&root);
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(scene.objects[0].info.submeshes[0].document_primitive, 2);
    let remaining = parsed(&scene);
    assert_eq!(
        (&remaining["meshes"][0]["primitives"][0], &remaining["meshes"][1]["primitives"][0]),
        (&lines, &flat)
    );
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
}

#[test]
fn images_in_data_uris_become_bytes_and_names_stay() {
    let mut b = Builder::default();
    let p = b.zigzag(3);
    let mut root = b.with_meshes(&json!([{ "primitives": [{ "attributes": { "POSITION": p } }] }]));
    root["images"] = json!([{ "uri": "data:image/png;base64,AQID" },
        { "uri": "some%20where/x.png" }, { "uri": "data:image/png;base64,!" }]);
    let scene = sound(&root);
    let remaining = parsed(&scene);
    assert_eq!(remaining["images"][0], json!({ "mimeType": "image/png", "bufferView": 0 }));
    assert_eq!(
        (&remaining["images"][1], &remaining["images"][2]),
        (&root["images"][1], &root["images"][2])
    );
    assert_eq!(gltf(&scene).blob(), [1, 2, 3]);
}

#[test]
fn versions_and_required_extensions_decide_what_is_read() {
    let with = |asset: Value, required: Value| {
        read(&json!({ "asset": asset, "extensionsRequired": required }))
            .map(|_| ())
            .map_err(|e| (e.fault, e.location))
    };
    let unsupported = |location: &str| Err((Fault::Unsupported, location.to_owned()));
    assert_eq!(with(json!({ "version": "2.9", "minVersion": "2.0" }), json!([])), Ok(()));
    assert_eq!(
        with(json!({ "version": "2.9" }), json!(["KHR_materials_unlit", "KHR_texture_basisu"])),
        Ok(())
    );
    assert_eq!(with(json!({ "version": "1.0" }), json!([])), unsupported("asset.version"));
    assert_eq!(with(json!({ "version": "3.0" }), json!([])), unsupported("asset.version"));
    assert_eq!(
        with(json!({ "version": "2.1", "minVersion": "2.1" }), json!([])),
        unsupported("asset.minVersion")
    );
    assert_eq!(
        with(json!({ "version": "2.0" }), json!(["X_new_geometry"])),
        unsupported("extensionsRequired")
    );
    assert_eq!(
        with(json!({ "version": "2" }), json!([])),
        Err((Fault::Malformed, "asset.version".to_owned()))
    );
}

#[test]
fn every_kind_of_reference_must_lead_somewhere() {
    for (root, location) in [
        (json!({ "scene": 0 }), "scene"),
        (json!({ "nodes": [{ "mesh": 1 }] }), "nodes[0].mesh"),
        (json!({ "nodes": [{ "children": [7] }] }), "nodes[0].children[0]"),
        (json!({ "textures": [{ "source": -1 }] }), "textures[0].source"),
        (json!({ "skins": [{ "joints": [0.5] }] }), "skins[0].joints[0]"),
        (
            json!({ "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": 1, "type": "SCALAR" },
            ] }),
            "accessors[0].bufferView",
        ),
        (json!({ "nodes": {} }), "nodes"),
        (json!({ "meshes": [{ "primitives": 3 }] }), "meshes[0].primitives"),
    ] {
        let mut root = root;
        root["asset"] = json!({ "version": "2.0" });
        let e = read(&root).expect_err(location);
        assert_eq!((e.fault, e.location.as_str()), (Fault::Malformed, location));
    }
}
