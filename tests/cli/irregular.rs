//! Harmless irregularities that other readers accept are read, each with a warning.

use crate::support::{Folder, grid, scene};
use serde_json::{Value, json};

/// A grid as glTF, changed.
fn changed(change: impl FnOnce(&mut Value)) -> String {
    let mut root: Value = serde_json::from_str(&scene(&[1.0], 8)).expect("a scene");
    change(&mut root);
    root.to_string()
}

/// Extracts every triangle of a file that must be read with this warning.
#[track_caller]
fn read_with(f: &Folder, name: &str, warning: &str) -> Value {
    let run = f.lodc(["extract", name, "--lod", "0", "-o", "o.glb", "--json"]).ends(0);
    assert!(run.err.contains(warning), "{name}: {}", run.err);
    let report = run.json();
    assert_eq!(report["triangles"], 128, "{name}: {report}");
    report
}

#[test]
fn an_offset_without_a_view_is_zeros() {
    let f = Folder::new();
    let root = changed(|root| {
        root["accessors"].as_array_mut().expect("accessors").push(json!({
            "byteOffset": 0, "componentType": 5126, "count": 81, "type": "VEC3",
            "min": [0, 0, 0], "max": [0, 0, 0]}));
        root["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 2}]);
    });
    f.file("a.gltf", root);
    read_with(&f, "a.gltf", "1 accessor has a byteOffset but no bufferView: the offset is ignored");
}

#[test]
fn a_primitive_without_vertices_is_dropped() {
    let f = Folder::new();
    let root = changed(|root| {
        root["bufferViews"]
            .as_array_mut()
            .expect("views")
            .push(json!({"buffer": 0, "byteOffset": 0, "byteLength": 0}));
        root["accessors"]
            .as_array_mut()
            .expect("accessors")
            .push(json!({"bufferView": 2, "componentType": 5126, "count": 0, "type": "VEC3"}));
        let empty = json!({"attributes": {"POSITION": 2}});
        root["meshes"][0]["primitives"].as_array_mut().expect("primitives").push(empty.clone());
        // A mesh that has nothing else is gone, and the node shows nothing.
        root["meshes"].as_array_mut().expect("meshes").push(json!({"primitives": [empty]}));
        root["nodes"].as_array_mut().expect("nodes").push(json!({"mesh": 1, "name": "bare"}));
    });
    f.file("a.gltf", root);
    read_with(&f, "a.gltf", "2 primitives without a vertex were dropped");
    f.lodc(["verify", "o.glb", "--source", "a.gltf"]).ends(0);
}

#[test]
fn a_third_texture_coordinate_is_dropped() {
    let f = Folder::new();
    let root = changed(|root| {
        // The positions serve as texture coordinates.
        root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(0);
    });
    f.file("a.gltf", root);
    read_with(&f, "a.gltf", "third texture coordinate");
    let run = f.lodc(["extract", "a.gltf", "--lod", "0", "-o", "o.obj"]).ends(0);
    assert!(run.err.contains("third texture coordinate"));
    let obj = String::from_utf8(f.read("o.obj")).expect("text");
    assert!(obj.lines().filter(|l| l.starts_with("vt ")).all(|l| l.split(' ').count() == 3));
}

#[test]
fn the_last_vertex_of_65536_can_be_named_in_a_list() {
    let f = Folder::new();
    let n = 255;
    let root = changed(|root| {
        *root = serde_json::from_str(&scene(&[1.0], n)).expect("a scene");
        // Indices of 16 bits.
        let uri = root["buffers"][0]["uri"].as_str().expect("data").to_owned();
        let (head, text) = uri.split_once(',').expect("a comma");
        let mut bytes = crate::support::unbase64(text);
        let start = root["bufferViews"][1]["byteOffset"].as_u64().expect("an offset") as usize;
        let short: Vec<u8> = bytes[start..].chunks(4).flat_map(|b| [b[0], b[1]]).collect();
        bytes.truncate(start);
        bytes.extend(&short);
        root["bufferViews"][1]["byteLength"] = json!(short.len());
        root["buffers"][0]["byteLength"] = json!(bytes.len());
        root["buffers"][0]["uri"] = json!(format!("{head},{}", crate::support::base64(&bytes)));
        root["accessors"][1]["componentType"] = json!(5123);
    });
    f.file("a.gltf", root);
    let run = f.lodc(["extract", "a.gltf", "--ratio", "10%", "-o", "o.glb", "--json"]).ends(0);
    let report = run.json();
    let share = report["triangles"].as_f64().unwrap_or(0.0) / (2 * n * n) as f64;
    assert!((share - report["kept_share"].as_f64().unwrap_or(0.0)).abs() < 1e-6, "{report}");
}

#[test]
fn indices_of_normals_that_the_file_lacks_are_ignored() {
    let f = Folder::new();
    let with = |corner: &dyn Fn(&str) -> String| -> String {
        let line = |line: &str| match line.strip_prefix("f ") {
            Some(rest) => {
                let corners: Vec<String> = rest.split(' ').map(corner).collect();
                format!("f {}\n", corners.join(" "))
            }
            None => format!("{line}\n"),
        };
        grid(8).lines().map(line).collect()
    };
    f.file("normals.obj", with(&|v| format!("{v}//{v}")));
    read_with(&f, "normals.obj", "use normals, but the file has none");
    f.file("relative.obj", with(&|v| format!("{v}//-1")));
    read_with(&f, "relative.obj", "use normals, but the file has none");
    f.file("both.obj", with(&|v| format!("{v}/{v}/{v}")));
    read_with(&f, "both.obj", "use texture coordinates, but the file has none");
    // 0 is none, whether the file has any or not.
    f.file("zero.obj", with(&|v| format!("{v}/0/0")));
    read_with(&f, "zero.obj", "512 indices 0 of texture coordinates or normals");
    f.file("zeros.obj", format!("vn 0 0 1\n{}", with(&|v| format!("{v}//0"))));
    read_with(&f, "zeros.obj", "indices 0 of texture coordinates or normals are taken for none");
    f.file("position.obj", with(&|v| v.replace('5', "0")));
    let run = f.lodc(["extract", "position.obj", "--lod", "0", "-o", "o.glb"]).fails(3);
    assert!(run.err.contains("indices start at 1"), "{}", run.err);
    // Where there are some, an index beyond them is an error.
    f.file("beyond.obj", format!("vn 0 0 1\n{}", with(&|v| format!("{v}//{v}"))));
    let run = f.lodc(["extract", "beyond.obj", "--lod", "0", "-o", "o.glb"]).fails(3);
    assert!(run.err.contains("normal 2 does not exist (the file has 1)"), "{}", run.err);
}

#[test]
fn base64_may_be_broken_into_lines_and_backslashes_are_slashes() {
    let f = Folder::new();
    let broken = changed(|root| {
        let uri = root["buffers"][0]["uri"].as_str().expect("data").to_owned();
        let (head, text) = uri.split_once(',').expect("a comma");
        let lines: Vec<&str> =
            text.as_bytes().chunks(76).map(|c| std::str::from_utf8(c).expect("ASCII")).collect();
        root["buffers"][0]["uri"] = json!(format!("{head},{}", lines.join("\r\n")));
    });
    f.file("lines.gltf", broken);
    read_with(&f, "lines.gltf", "1 data URI has white space, which is ignored");
    let mut bytes = Vec::new();
    let backslash = changed(|root| {
        let uri = root["buffers"][0]["uri"].as_str().expect("data").to_owned();
        bytes = crate::support::unbase64(uri.split_once(',').expect("a comma").1);
        root["buffers"][0]["uri"] = json!("sub\\m.bin");
    });
    f.file("sub/m.bin", &bytes);
    f.file("slash.gltf", backslash);
    read_with(&f, "slash.gltf", "1 URI has backslashes, which are read as slashes");
}
