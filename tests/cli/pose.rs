//! `--pose`: scenes at a moment of an animation.

use crate::support::{Folder, base64, scene};
use serde_json::{Value, json};

/// Two grids; an animation moves the second one from x = 20 to x = 1020 within a second.
fn animated() -> String {
    let mut root: Value = serde_json::from_str(&scene(&[1.0, 1.0], 8)).expect("a glTF");
    let numbers = [0.0f32, 1.0, 20.0, 0.0, 0.0, 1020.0, 0.0, 0.0];
    let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", base64(&bytes));
    let mut push = |list: &str, value: Value| {
        let list = root[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    };
    let buffer = push("buffers", json!({ "byteLength": bytes.len(), "uri": uri }));
    let times = push("bufferViews", json!({ "buffer": buffer, "byteLength": 8 }));
    let places =
        push("bufferViews", json!({ "buffer": buffer, "byteOffset": 8, "byteLength": 24 }));
    let input = push(
        "accessors",
        json!({ "bufferView": times, "componentType": 5126, "count": 2, "type": "SCALAR",
                "min": [0.0], "max": [1.0] }),
    );
    let output = push(
        "accessors",
        json!({ "bufferView": places, "componentType": 5126, "count": 2, "type": "VEC3" }),
    );
    root["animations"] = json!([{
        "name": "go",
        "samplers": [{ "input": input, "output": output }],
        "channels": [{ "sampler": 0, "target": { "node": 1, "path": "translation" } }],
    }]);
    root.to_string()
}

fn diagonal(f: &Folder, input: &str, pose: &[&str]) -> f64 {
    let args = ["compare", input, input, "--json", "--views", "0", "--samples", "100"];
    let run = f.lodc(args.iter().chain(pose)).ends(0);
    run.json()["diagonal"].as_f64().expect("a length")
}

#[test]
fn an_animation_moves_what_is_compared_and_looked_at() {
    let f = Folder::new();
    f.file("s.gltf", animated());
    f.lodc(["build", "s.gltf", "-o", "s.lodc", "-q"]).ends(0);
    for input in ["s.gltf", "s.lodc"] {
        let rest = diagonal(&f, input, &[]);
        for (pose, moved) in [("go@0.5", 500.0), ("0@1", 1000.0), ("go@9", 1000.0), ("go", 0.0)] {
            let posed = diagonal(&f, input, &["--pose", pose]);
            assert!((posed - rest - moved).abs() < 5.0, "{input} {pose}: {rest} {posed}");
        }
        // The grid is whole where the animation has brought it by then.
        let kept = |pose: &[&str]| {
            let sphere = ["--criterion", "sphere", "--target", "524,4,0", "--radius", "20"];
            let args = ["extract", input, "-o", "o.glb", "--json", "-q"];
            let run = f.lodc(args.iter().chain(&sphere).chain(pose)).ends(0);
            run.json()["objects"][1]["triangles"].as_u64().expect("a count")
        };
        assert_eq!(kept(&["--pose", "go@0.5"]), 128, "{input}");
        assert!(kept(&[]) < 64 && kept(&["--pose", "go@1"]) < 64, "{input}");
    }
}

#[test]
fn an_animation_that_is_not_there_is_named_with_those_that_are() {
    let f = Folder::new();
    f.file("s.gltf", animated());
    f.file("still.gltf", scene(&[1.0], 2));
    for (input, pose, says) in
        [("s.gltf", "run@1", "0 go"), ("s.gltf", "1@1", "0 go"), ("still.gltf", "0@1", "none")]
    {
        let run = f.lodc(["compare", input, input, "--pose", pose]).fails(2);
        assert!(run.err.contains(says), "{input} {pose}: {}", run.err);
    }
    f.lodc(["extract", "s.gltf", "-o", "o.glb", "--ratio", "1", "--pose", "0@1"]).fails(2);
    f.lodc(["compare", "s.gltf", "s.gltf", "--pose", "go@later"]).ends(2);
}
