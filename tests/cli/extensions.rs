//! Extensions of glTF: what their indices lead to is there at every level, geometry that nothing
//! names is gone.

use crate::support::{Folder, base64, glb_document, outside, scene, script, unbase64};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// Two grids of 1,152 triangles each, changed, with further bytes behind theirs.
fn changed(change: impl FnOnce(&mut Value, &mut Vec<u8>)) -> String {
    let mut root: Value = serde_json::from_str(&scene(&[1.0, 0.5], 24)).expect("a scene");
    let uri = root["buffers"][0]["uri"].as_str().expect("data").to_owned();
    let (head, text) = uri.split_once(',').expect("a comma");
    let mut bytes = unbase64(text);
    change(&mut root, &mut bytes);
    root["buffers"][0]["byteLength"] = json!(bytes.len());
    root["buffers"][0]["uri"] = json!(format!("{head},{}", base64(&bytes)));
    root.to_string()
}

/// Adds a buffer view of these bytes; returns its number.
fn view(root: &mut Value, bytes: &mut Vec<u8>, content: &[u8]) -> usize {
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let views = root["bufferViews"].as_array_mut().expect("views");
    views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": content.len()}));
    bytes.extend(content);
    root["bufferViews"].as_array().map_or(0, Vec::len) - 1
}

/// The bytes of a view of a GLB.
fn content(root: &Value, bin: &[u8], view: &Value) -> Vec<u8> {
    let view = &root["bufferViews"][view.as_u64().expect("an index") as usize];
    let start = view["byteOffset"].as_u64().unwrap_or(0) as usize;
    bin[start..start + view["byteLength"].as_u64().expect("a length") as usize].to_vec()
}

/// Writes an input as GLB and a level with 10 % of its triangles; returns the level's document and
/// bytes. The level has to be smaller, and what verify knows of.
#[track_caller]
fn tenth(f: &Folder, text: &str) -> (Value, Vec<u8>) {
    f.file("in.gltf", text);
    let run = f.lodc(["extract", "in.gltf", "--ratio", "10%", "-o", "out.glb"]).ends(0);
    let binary = f.read("out.glb").len();
    let input = text.len() * 3 / 4;
    assert!(binary < input, "{binary} bytes of {input}: {}", run.err);
    f.lodc(["verify", "out.glb", "--source", "in.gltf"]).ends(0);
    glb_document(&f.read("out.glb"))
}

#[test]
fn views_of_profiles_and_shaders_follow() {
    let f = Folder::new();
    for (extension, list) in [
        ("EXT_lights_ies", "lights"),
        ("KHR_techniques_webgl", "shaders"),
        ("KHR_audio_emitter", "audio"),
        ("NV_materials_mdl", "modules"),
    ] {
        let text = changed(|root, bytes| {
            let views: Vec<Value> = ["first text", "second, longer text"]
                .map(|t| json!({"bufferView": view(root, bytes, t.as_bytes())}))
                .to_vec();
            root["extensionsUsed"] = json!([extension]);
            root["extensions"] = json!({extension: {list: views}});
        });
        let (root, bin) = tenth(&f, &text);
        let entries = &root["extensions"][extension][list];
        assert_eq!(content(&root, &bin, &entries[0]["bufferView"]), b"first text");
        assert_eq!(content(&root, &bin, &entries[1]["bufferView"]), b"second, longer text");
        // What verify calls unchanged are the bytes, not the numbers.
        let mut damaged = root.clone();
        let swapped = entries[1]["bufferView"].clone();
        damaged["extensions"][extension][list][0]["bufferView"] = swapped;
        f.file("bad.glb", joined(&damaged, &bin));
        let run = f.lodc(["verify", "bad.glb", "--source", "in.gltf"]).ends(1);
        assert!(run.text().contains(list) || run.err.contains(list), "{}{}", run.text(), run.err);
    }
}

/// A GLB of a document and its bytes.
fn joined(root: &Value, bin: &[u8]) -> Vec<u8> {
    let mut json = root.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend((28 + json.len() as u32 + bin.len() as u32).to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(json);
    out.extend((bin.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(bin);
    out
}

/// An avatar of VRM 0.x: expressions by mesh, spring bones by node.
fn vrm0(root: &mut Value) {
    root["extensionsUsed"] = json!(["VRM"]);
    root["extensions"] = json!({"VRM": {
        "meta": {"title": "x", "texture": -1},
        "humanoid": {"humanBones": [{"bone": "head", "node": 1}]},
        "firstPerson": {"firstPersonBone": -1, "meshAnnotations": [
            {"mesh": 0, "firstPersonFlag": "Both"},
            {"mesh": 1, "firstPersonFlag": "ThirdPersonOnly"}]},
        "blendShapeMaster": {"blendShapeGroups": [{"name": "A", "binds": [
            {"mesh": 1, "index": 0, "weight": 100}, {"mesh": 0, "index": 0, "weight": 50}]}]},
        "secondaryAnimation": {"boneGroups": [{"bones": [0, 1], "center": -1}],
            "colliderGroups": [{"node": 1, "colliders": [{"radius": 1}]}]}}});
}

/// An avatar of VRM 1.0: expressions and flags by node.
fn vrm1(root: &mut Value) {
    root["extensionsUsed"] = json!(["VRMC_vrm", "VRMC_springBone", "VRMC_node_constraint"]);
    let bind = |node: u32| json!({"node": node, "index": 0, "weight": 1.0});
    root["extensions"] = json!({
        "VRMC_vrm": {"specVersion": "1.0", "humanoid": {"humanBones": {"head": {"node": 1}}},
            "firstPerson": {"meshAnnotations": [{"node": 1, "type": "thirdPersonOnly"}]},
            "expressions": {"preset": {"aa": {"morphTargetBinds": [bind(1), bind(0)]}}}},
        "VRMC_springBone": {"specVersion": "1.0", "colliders": [{"node": 1, "shape": {}}],
            "springs": [{"joints": [{"node": 0}, {"node": 1}], "center": 0}]}});
    root["nodes"][0]["extensions"] = json!({"VRMC_node_constraint": {"specVersion": "1.0",
        "constraint": {"roll": {"source": 1, "rollAxis": "X"}}}});
}

/// Gives both meshes a morph target that moves some vertices up.
fn with_target(root: &mut Value, bytes: &mut Vec<u8>) {
    let deltas: Vec<u8> = (0..625u32)
        .flat_map(|i| [0.0, 0.0, if i % 7 == 0 { 0.5f32 } else { 0.0 }])
        .flat_map(f32::to_le_bytes)
        .collect();
    let view = view(root, bytes, &deltas);
    root["accessors"].as_array_mut().expect("accessors").push(json!({"bufferView": view,
        "componentType": 5126, "count": 625, "type": "VEC3", "min": [0, 0, 0],
        "max": [0, 0, 0.5]}));
    for mesh in root["meshes"].as_array_mut().expect("meshes") {
        mesh["primitives"][0]["targets"] = json!([{"POSITION": 2}]);
    }
}

#[test]
fn avatars_keep_what_they_name_at_every_level() {
    for (avatar, name) in [(vrm0 as fn(&mut Value), "VRM"), (vrm1, "VRMC_vrm")] {
        let f = Folder::new();
        let text = changed(|root, bytes| {
            with_target(root, bytes);
            avatar(root);
        });
        let (root, _) = tenth(&f, &text);
        let source: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(root["extensions"], source["extensions"]);
        // `.vrm` is a GLB, in and out, in folders too.
        f.lodc(["extract", "in.gltf", "--ratio", "1", "-o", "a.vrm"]).ends(0);
        fs::create_dir(f.join("avatars")).expect("a folder");
        fs::rename(f.join("a.vrm"), f.join("avatars/a.vrm")).expect("renamed");
        f.lodc(["extract", "avatars", "--ratio", "50%", "-o", "levels"]).ends(0);
        assert!(f.has("levels/a.vrm.glb"));
        f.lodc(["chain", "avatars/a.vrm", "-o", "chain.vrm"]).ends(0);
        f.lodc(["verify", "chain.vrm", "--source", "avatars/a.vrm"]).ends(0);
        let (root, _) = glb_document(&f.read("chain.vrm"));
        // Every mesh, or node that shows one, of every level has its binds.
        let (binds, key) = match name {
            "VRM" => (
                &root["extensions"]["VRM"]["blendShapeMaster"]["blendShapeGroups"][0]["binds"],
                "mesh",
            ),
            _ => (
                &root["extensions"][name]["expressions"]["preset"]["aa"]["morphTargetBinds"],
                "node",
            ),
        };
        let mut bound: Vec<u64> =
            binds.as_array().expect("binds").iter().filter_map(|b| b[key].as_u64()).collect();
        bound.sort_unstable();
        let count = match key {
            "mesh" => root["meshes"].as_array().map_or(0, Vec::len),
            _ => root["nodes"].as_array().map_or(0, Vec::len),
        };
        assert_eq!(bound, (0..count as u64).collect::<Vec<_>>(), "{name}");
        assert!(count > 2, "{name}");
    }
}

#[test]
fn a_mesh_that_is_gone_takes_what_is_about_it_along() {
    let f = Folder::new();
    let text = changed(|root, bytes| {
        with_target(root, bytes);
        vrm0(root);
        // So small beside the other that it disappears.
        root["nodes"][1]["scale"] = json!([0.0001, 0.0001, 0.0001]);
    });
    f.file("in.gltf", text);
    f.lodc(["extract", "in.gltf", "--triangles", "20", "-o", "out.glb"]).ends(0);
    let (root, _) = glb_document(&f.read("out.glb"));
    let meshes = root["meshes"].as_array().map_or(0, Vec::len);
    let vrm = &root["extensions"]["VRM"];
    for list in [
        &vrm["blendShapeMaster"]["blendShapeGroups"][0]["binds"],
        &vrm["firstPerson"]["meshAnnotations"],
    ] {
        let list = list.as_array().expect("a list");
        assert_eq!(list.len(), meshes, "{list:?}");
        assert!(list.iter().all(|b| b["mesh"].as_u64().is_some_and(|m| (m as usize) < meshes)));
    }
    f.lodc(["verify", "out.glb", "--source", "in.gltf"]).ends(0);
}

#[test]
fn an_unknown_extension_keeps_its_numbers_and_own_data_but_no_dead_weight() {
    let f = Folder::new();
    let text = changed(|root, bytes| {
        let own = view(root, bytes, b"data of its own");
        root["extensionsUsed"] = json!(["ACME_anything"]);
        root["extensions"] = json!({"ACME_anything": {"data": own, "mass": 1, "scene": [0, 1]}});
    });
    let (root, bin) = tenth(&f, &text);
    assert_eq!(root["extensions"]["ACME_anything"]["data"], 2);
    assert_eq!(content(&root, &bin, &json!(2)), b"data of its own");
    for emptied in [0, 1] {
        assert!(content(&root, &bin, &json!(emptied)).len() <= 4, "{root}");
    }
    let run = f.lodc(["extract", "in.gltf", "--ratio", "10%", "-o", "out.glb"]).ends(0);
    assert!(run.err.contains("the extension ACME_anything is unknown"), "{}", run.err);
}

#[test]
fn implicit_feature_ids_name_the_vertices_that_they_named() {
    let f = Folder::new();
    let text = changed(|root, _| {
        root["extensionsUsed"] = json!(["EXT_mesh_features"]);
        root["meshes"][0]["primitives"][0]["extensions"] =
            json!({"EXT_mesh_features": {"featureIds": [{"featureCount": 625}]}});
    });
    let (root, bin) = tenth(&f, &text);
    let primitive = &root["meshes"][0]["primitives"][0];
    assert_eq!(
        primitive["extensions"]["EXT_mesh_features"]["featureIds"][0]["attribute"],
        json!(0)
    );
    let floats = |name: &str, components: usize| -> Vec<f32> {
        let accessor = primitive["attributes"][name].as_u64().expect("an accessor") as usize;
        let accessor = &root["accessors"][accessor];
        let view = &root["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize];
        let number = |v: &Value| v.as_u64().unwrap_or(0) as usize;
        let start = number(&view["byteOffset"]) + number(&accessor["byteOffset"]);
        let stride = number(&view["byteStride"]).max(4 * components);
        let value = |at: usize| f32::from_le_bytes(bin[at..at + 4].try_into().expect("four"));
        (0..number(&accessor["count"]))
            .flat_map(|i| (0..components).map(move |c| start + i * stride + 4 * c))
            .map(value)
            .collect()
    };
    let (positions, ids) = (floats("POSITION", 3), floats("_FEATURE_ID_0", 1));
    assert!(!ids.is_empty());
    for (p, id) in positions.chunks(3).zip(ids) {
        // Vertices of the grid are numbered row by row.
        assert_eq!(p[1] * 25.0 + p[0], id);
    }
}

#[test]
fn the_table_has_what_packages_declare() {
    let Some(modules) = outside("LODC_DECLARATIONS") else { return };
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/EXTENSIONS.md");
    let f = Folder::new();
    // What packages declare, beside a page with the table.
    let declared = |page: &Path| script("extensions.mjs", f.path(), [modules.as_path(), page]);
    let seen = declared(&page);
    assert_eq!(seen["differences"], json!([]));
    assert!(seen["indices"].as_u64() > Some(70), "{seen}");
    // One row less, and one that nothing declares.
    let row = "nodes[].extensions.VRMC_node_constraint.constraint.aim.source";
    let text =
        fs::read_to_string(page).expect("the page is there").replace(row, &format!("{row}s"));
    f.file("page.md", text);
    let seen = declared(&f.path().join("page.md"));
    let differences = [format!("the table lacks {row}"), format!("no package declares {row}s")];
    assert_eq!(seen["differences"], json!(differences));
}
