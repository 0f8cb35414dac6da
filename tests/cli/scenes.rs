//! Scenes as people have them: what is written of seams, targets, skins and hidden meshes is
//! accepted, levels inside are replaced, and nothing is carried along that nothing names.

use crate::placements::Scene;
use crate::support::{Folder, glb_document};
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// A folder with a scene, its chain, and what `verify` says of it: all is well.
fn chained(scene: &str, options: &[&str]) -> Folder {
    let f = Folder::new();
    f.file("s.gltf", scene);
    f.lodc(["chain", "s.gltf", "-q", "-o", "c.glb"].iter().chain(options)).ends(0);
    f.lodc(["verify", "c.glb", "--source", "s.gltf"]).ends(0);
    f
}

pub(crate) fn number_of(scene: &Scene, accessor: usize) -> usize {
    scene.accessors[accessor]["count"].as_u64().expect("a count") as usize
}

/// Vertices of the first mesh.
pub(crate) fn vertices(scene: &Scene, mesh: usize) -> usize {
    let position = &scene.meshes[mesh]["primitives"][0]["attributes"]["POSITION"];
    number_of(scene, position.as_u64().expect("an accessor") as usize)
}

/// A bowl with a seam whose two sides differ by the rounding of an angle.
pub(crate) fn lathe(columns: usize, rows: usize) -> String {
    let mut scene = Scene::default();
    let mut points: Vec<f32> = Vec::new();
    for row in 0..=rows {
        let v = row as f64 / rows as f64;
        for column in 0..=columns {
            let angle = TAU * column as f64 / columns as f64;
            let radius = 0.2 + 0.7 * (3.0 * v).sin().abs() + 0.02 * (5.0 * angle).cos();
            points.extend([radius * angle.cos(), 2.0 * v, -radius * angle.sin()].map(|x| x as f32));
        }
    }
    let mut corners: Vec<u32> = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let a = (row * (columns + 1) + column) as u32;
            let b = a + columns as u32 + 1;
            corners.extend([a, a + 1, b + 1, a, b + 1, b]);
        }
    }
    scene.mesh("bowl", &points, &corners);
    scene.file(&[0], &json!({"nodes": [{"mesh": 0}]}))
}

#[test]
fn seams_off_by_rounding_morph() {
    for (columns, rows) in [(12, 16), (17, 12), (24, 20)] {
        for more in [&["--geomorph"][..], &["--geomorph", "--auto", "7"]] {
            chained(&lathe(columns, rows), more);
        }
    }
}

/// Adds morph targets to the first mesh, every other one as a sparse accessor.
pub(crate) fn add_targets(scene: &mut Scene, count: usize) {
    let vertices = vertices(scene, 0);
    let targets: Vec<Value> = (0..count)
        .map(|t| {
            let delta = |v: usize, k: usize| {
                let angle = v as f64 * (0.7 + 0.1 * t as f64) + 2.0 * k as f64;
                (0.05 * (angle.sin() + (0.3 * angle).cos())) as f32
            };
            let all = |v: usize| [0, 1, 2].map(|k| delta(v, k));
            let bounds = |accessor: &mut Value| {
                accessor["min"] = json!([-0.1, -0.1, -0.1]);
                accessor["max"] = json!([0.1, 0.1, 0.1]);
            };
            if t % 2 == 0 {
                let values: Vec<f32> = (0..vertices).flat_map(all).collect();
                let accessor = scene.floats(&values, "VEC3");
                bounds(&mut scene.accessors[accessor]);
                return json!({"POSITION": accessor});
            }
            let moved: Vec<usize> = (0..vertices).step_by(3).collect();
            let numbers: Vec<u8> = moved.iter().flat_map(|&v| (v as u32).to_le_bytes()).collect();
            let values: Vec<u8> =
                moved.iter().flat_map(|&v| all(v)).flat_map(f32::to_le_bytes).collect();
            let indices = scene.view(&numbers);
            let values = scene.view(&values);
            let mut accessor = json!({"componentType": 5126, "count": vertices, "type": "VEC3",
                "sparse": {"count": moved.len(), "values": {"bufferView": values},
                           "indices": {"bufferView": indices, "componentType": 5125}}});
            bounds(&mut accessor);
            scene.accessors.push(accessor);
            json!({"POSITION": scene.accessors.len() - 1})
        })
        .collect();
    scene.meshes[0]["primitives"][0]["targets"] = targets.into();
    scene.meshes[0]["weights"] = vec![0.5; count].into();
}

/// An animation of weights that go from 0 to 1 and to −0.5.
pub(crate) fn moving_weights(scene: &mut Scene, targets: usize) -> Value {
    let times = scene.floats(&[0.0, 0.5, 1.0], "SCALAR");
    scene.accessors[times]["min"] = json!([0.0]);
    scene.accessors[times]["max"] = json!([1.0]);
    let values: Vec<f32> = [0.0, 1.0, -0.5].iter().flat_map(|&w| vec![w; targets]).collect();
    let values = scene.floats(&values, "SCALAR");
    json!([{"samplers": [{"input": times, "output": values}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}]}])
}

#[test]
fn errors_contain_what_rounding_does_to_targets() {
    for count in [1, 2, 4, 8] {
        let mut scene = Scene::of_rocks(&[12]);
        add_targets(&mut scene, count);
        let animations = moving_weights(&mut scene, count);
        let more = json!({"nodes": [{"mesh": 0}], "animations": animations});
        for bits in ["pos=14", "pos=9"] {
            chained(&scene.file(&[0], &more), &["--quantize", bits]);
        }
    }
}

/// Adds a chain of joints to the first mesh, whose vertices have `sets` times four weights.
pub(crate) fn add_skin(scene: &mut Scene, joints: usize, sets: usize) -> Value {
    let vertices = vertices(scene, 0);
    for set in 0..sets {
        let joint = |v: usize, k: usize| (v + 4 * set + k) % joints;
        let numbers: Vec<u8> =
            (0..vertices).flat_map(|v| [0, 1, 2, 3].map(|k| joint(v, k) as u8)).collect();
        let share = |v: usize, k: usize| 1.0 + ((v * 7 + k * 3 + set * 5) % 11) as f32;
        let all = |v: usize| -> f32 {
            (0..4 * sets).map(|k| 1.0 + ((v * 7 + k % 4 * 3 + k / 4 * 5) % 11) as f32).sum()
        };
        let weights: Vec<f32> =
            (0..vertices).flat_map(|v| [0, 1, 2, 3].map(|k| share(v, k) / all(v))).collect();
        let numbers = scene.accessor(&numbers, 5121, vertices, "VEC4");
        let weights = scene.floats(&weights, "VEC4");
        let attributes = &mut scene.meshes[0]["primitives"][0]["attributes"];
        attributes[format!("JOINTS_{set}")] = numbers.into();
        attributes[format!("WEIGHTS_{set}")] = weights.into();
    }
    let matrix = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let kind = scene.floats(&matrix.map(|x| x as f32).repeat(joints), "VEC4");
    scene.accessors[kind]["type"] = "MAT4".into();
    scene.accessors[kind]["count"] = joints.into();
    let numbers: Vec<usize> = (1..=joints).collect();
    json!([{"joints": numbers, "inverseBindMatrices": kind}])
}

#[test]
fn errors_contain_what_rounding_does_to_skins() {
    for sets in [1, 2] {
        let mut scene = Scene::of_rocks(&[10]);
        let skins = add_skin(&mut scene, 8, sets);
        let mut nodes = vec![json!({"mesh": 0, "skin": 0})];
        for j in 0..8 {
            let angle = 0.1 * f64::from(j);
            let turned = [0.0, (angle / 2.0).sin(), 0.0, (angle / 2.0).cos()];
            let at = [0.1 * f64::from(j), 0.0, 0.2];
            nodes.push(json!({"translation": at, "rotation": turned}));
        }
        let roots: Vec<usize> = (0..9).collect();
        let file = scene.file(&roots, &json!({"nodes": nodes, "skins": skins}));
        for more in [
            &["--geomorph"][..],
            &["--quantize", "pos=14"],
            &["--quantize", "pos=14,weight=8"],
            &["--quantize", "weight=6"],
        ] {
            chained(&file, more);
        }
    }
}

#[test]
fn meshes_that_no_scene_shows_are_measured_in_their_numbers() {
    let hidden = [
        json!({"mesh": 1, "translation": [5, 0, 0]}),
        json!({"mesh": 1, "scale": [0, 0, 0]}),
        json!({"name": "nothing"}),
    ];
    for (number, node) in hidden.into_iter().enumerate() {
        let nodes = json!([{"mesh": 0, "scale": [3, 3, 3]}, node]);
        let roots: &[usize] = if number == 0 { &[0] } else { &[0, 1] };
        let file = Scene::of_rocks(&[10, 12]).file(roots, &json!({"nodes": nodes}));
        let f = chained(&file, &["--quantize", "pos=14"]);
        let half = ["extract", "s.gltf", "--ratio", "50%", "--quantize", "pos=14", "-o", "h.glb"];
        f.lodc(half).ends(0);
        f.lodc(["verify", "h.glb", "--source", "s.gltf"]).ends(0);
    }
    // A scene that shows nothing at all.
    let file = Scene::of_rocks(&[10]).file(&[1], &json!({"nodes": [{"mesh": 0}, {}]}));
    chained(&file, &["--quantize", "pos=14"]);
}

#[test]
fn files_that_packing_makes_larger_stay_plain() {
    let f = Folder::new();
    let nodes: Vec<Value> =
        (0..150).map(|i| json!({"mesh": 0, "translation": [3 * i, 0, 0]})).collect();
    let roots: Vec<usize> = (0..150).collect();
    f.file("s.gltf", Scene::of_rocks(&[6]).file(&roots, &json!({"nodes": nodes})));
    f.file("large.gltf", Scene::of_rocks(&[24]).file(&[0], &json!({"nodes": [{"mesh": 0}]})));
    let packed = ["--compress", "meshopt", "--quantize", "pos=14"];
    let extract = ["extract", "--ratio", "1", "-o", "out.glb"];
    for command in [&["chain", "-o", "out.glb"][..], &extract] {
        for (input, is_packed) in [("s.gltf", false), ("large.gltf", true)] {
            let args = command.iter().chain(&packed).chain([&input]);
            let run = f.lodc(args).ends(0);
            assert_eq!(
                run.err.contains("written without quantisation and compression"),
                !is_packed
            );
            let (root, _) = glb_document(&f.read("out.glb"));
            assert_eq!(root["extensionsRequired"].is_array(), is_packed, "{input}");
            f.lodc(["verify", "out.glb", "--source", input]).ends(0);
        }
    }
}

/// A file with three levels of a rock, as other tools write it, animated; another rock beside it.
fn levels_of_others() -> Value {
    let mut scene = Scene::of_rocks(&[14, 8, 4, 10]);
    let times = scene.floats(&[0.0, 1.0], "SCALAR");
    scene.accessors[times]["min"] = json!([0.0]);
    scene.accessors[times]["max"] = json!([1.0]);
    let values = scene.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], "VEC3");
    let channels: Vec<Value> = [0, 1, 2, 4]
        .iter()
        .map(|node| json!({"sampler": 0, "target": {"node": node, "path": "translation"}}))
        .collect();
    let nodes = json!([
        {"mesh": 0, "name": "rock", "extensions": {"MSFT_lod": {"ids": [1, 2]}},
         "extras": {"MSFT_screencoverage": [0.5, 0.2, 0.01]}},
        {"mesh": 1, "name": "rock_1", "children": [3]},
        {"mesh": 2, "name": "rock_2"},
        {"name": "below"},
        {"mesh": 3, "name": "other"}]);
    let more = json!({"nodes": nodes, "extensionsUsed": ["MSFT_lod"],
        "animations": [{"samplers": [{"input": times, "output": values}], "channels": channels}]});
    serde_json::from_str(&scene.file(&[0, 4], &more)).expect("JSON")
}

fn length(list: &Value) -> usize {
    list.as_array().map_or(0, Vec::len)
}

#[test]
fn levels_inside_are_replaced() {
    let f = chained(&levels_of_others().to_string(), &[]);
    let (chain, _) = glb_document(&f.read("c.glb"));
    assert_eq!([length(&chain["meshes"]), length(&chain["nodes"])], [8, 8]);
    f.lodc(["extract", "s.gltf", "--ratio", "10%", "-q", "-o", "one.glb"]).ends(0);
    f.lodc(["verify", "one.glb", "--source", "s.gltf"]).ends(0);
    let (one, bytes) = glb_document(&f.read("one.glb"));
    assert_eq!([length(&one["meshes"]), length(&one["nodes"])], [2, 2]);
    assert!(one["extensionsUsed"].is_null() && !one.to_string().contains("MSFT"), "{one}");
    let targets: Vec<&Value> = one["animations"][0]["channels"]
        .as_array()
        .expect("channels")
        .iter()
        .map(|channel| &channel["target"]["node"])
        .collect();
    assert_eq!(targets, [&json!(0), &json!(1)]);
    assert!(bytes.len() < 4_000, "{} bytes", bytes.len());
}

#[test]
fn chains_are_chained_again() {
    for more in [
        &[][..],
        &["--geomorph"],
        &["--index-ranges"],
        &["--quantize", "pos=14"],
        &["--geomorph", "--quantize", "pos=12", "--compress", "meshopt"],
    ] {
        let f = Folder::new();
        for fixture in ["machine_part.glb", "morphing_sphere.glb", "skinned_tube_u8.glb"] {
            let path = format!("{}/../fixtures/{fixture}", env!("CARGO_MANIFEST_DIR"));
            f.file("s.glb", std::fs::read(path).expect("a fixture"));
            f.lodc(["chain", "s.glb", "-q", "-o", "c.glb"].iter().chain(more)).ends(0);
            f.lodc(["chain", "c.glb", "-q", "-o", "again.glb"]).ends(0);
            f.lodc(["verify", "again.glb", "--source", "c.glb"]).ends(0);
            f.lodc(["chain", "s.glb", "-q", "-o", "plain.glb"]).ends(0);
            let [again, plain] = ["again.glb", "plain.glb"].map(|name| {
                let (root, _) = glb_document(&f.read(name));
                (length(&root["meshes"]), root["extras"]["lodc"]["levels"].clone())
            });
            assert_eq!(again.0, plain.0, "{fixture}, {more:?}");
            assert_eq!(length(&again.1), 4, "{fixture}, {more:?}");
            let extract = ["extract", "c.glb", "--ratio", "1", "-o", "one.glb", "--json"];
            let one = f.lodc(extract).ends(0).json();
            let source = f.lodc(["extract", "s.glb", "--ratio", "1", "-o", "one.glb", "--json"]);
            assert_eq!(one["triangles"], source.ends(0).json()["triangles"], "{fixture}, {more:?}");
        }
    }
}

#[test]
fn levels_that_are_shown_elsewhere_are_refused() {
    let f = Folder::new();
    let mut elsewhere = levels_of_others();
    elsewhere["nodes"][4]["children"] = json!([2]);
    let mut loops = levels_of_others();
    loops["nodes"][0]["extensions"]["MSFT_lod"]["ids"] = json!([0, 1]);
    for (file, words) in
        [(elsewhere, "nodes[2]: is a coarser level of nodes[0]"), (loops, "of itself")]
    {
        f.file("s.gltf", file.to_string());
        let run = f.lodc(["chain", "s.gltf", "-o", "c.glb"]).fails(3);
        assert!(run.err.contains(words), "{}", run.err);
    }
    // Beside the finest level a coarser one is a level all the same.
    let mut beside = levels_of_others();
    beside["scenes"][0]["nodes"] = json!([0, 1, 2, 4]);
    f.file("s.gltf", beside.to_string());
    let run = f.lodc(["extract", "s.gltf", "--ratio", "1", "-o", "one.glb", "--json"]).ends(0);
    assert_eq!(length(&run.json()["objects"]), 2);
}

#[test]
fn what_nothing_names_leaves_with_the_first_level() {
    let mut scene = Scene::of_rocks(&[8]);
    scene.view(&vec![7; 400_000]);
    let more = json!({"nodes": [{"mesh": 0}]});
    for extension in [false, true] {
        let f = Folder::new();
        let mut file: Value = serde_json::from_str(&scene.file(&[0], &more)).expect("JSON");
        if extension {
            file["extensionsUsed"] = json!(["ACME_anything"]);
            file["extensions"] = json!({"ACME_anything": {"number": 9}});
        }
        f.file("s.gltf", file.to_string());
        let run = f.lodc(["extract", "s.gltf", "--ratio", "50%", "-o", "half.glb"]).ends(0);
        assert_eq!(run.err.contains("ACME_anything is unknown"), extension);
        assert!(f.read("half.glb").len() < 20_000);
        f.lodc(["verify", "half.glb", "--source", "s.gltf"]).ends(0);
    }
}

#[test]
fn extras_that_are_no_object_are_kept_in_it_and_come_back() {
    for value in [json!("text"), json!([1, 2]), json!(0), json!(null)] {
        let mut scene = Scene::of_rocks(&[12]);
        scene.meshes[0]["extras"] = value.clone();
        scene.meshes[0]["primitives"][0]["extras"] = value.clone();
        let nodes = json!([{"mesh": 0, "extras": value}]);
        let more = json!({"nodes": nodes, "extras": value});
        let f = Folder::new();
        f.file("s.gltf", scene.file(&[0], &more));
        for args in [&[][..], &["--geomorph"], &["--index-ranges"]] {
            let chain = ["chain", "s.gltf", "-o", "chain.gltf"];
            let run = f.lodc(chain.iter().chain(args)).ends(0);
            assert!(run.err.contains("extras and 2 more: no object"), "{}", run.err);
            let chain: Value = serde_json::from_slice(&f.read("chain.gltf")).expect("JSON");
            assert_eq!(chain["extras"]["lodc"]["extras"], value);
            f.lodc(["verify", "chain.gltf", "--source", "s.gltf"]).ends(0);
            f.lodc(["extract", "chain.gltf", "--ratio", "0.5", "-o", "level.gltf"]).ends(0);
            let level: Value = serde_json::from_slice(&f.read("level.gltf")).expect("JSON");
            let mesh = &level["meshes"][0];
            for extras in [&level["nodes"][0], mesh, &mesh["primitives"][0]].map(|e| &e["extras"]) {
                assert_eq!(*extras, value, "{args:?}");
            }
        }
    }
}
