//! One mesh in many placements, at rest and in motion: what is stated of a level holds in world
//! units wherever and whenever the scene shows it.

use crate::support::{Folder, base64};
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// A closed, bumpy sphere of `n` by `2 n` faces, by default about 2 across.
fn rock(n: usize, seed: f64) -> (Vec<[f64; 3]>, Vec<u32>) {
    let columns = 2 * n;
    let bumpy = |[x, y, z]: [f64; 3]| {
        let wave = (5.0 * x + seed).sin() + (4.0 * y - z + seed).sin() + (7.0 * z + 2.0 * x).cos();
        [x, y, z].map(|c| c * (1.0 + 0.08 * wave))
    };
    let mut points = vec![bumpy([0.0, 1.0, 0.0])];
    for row in 1..n {
        let polar = TAU / 2.0 * row as f64 / n as f64;
        for column in 0..columns {
            let around = TAU * column as f64 / columns as f64;
            let at = [polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin()];
            points.push(bumpy(at));
        }
    }
    points.push(bumpy([0.0, -1.0, 0.0]));
    let (last, ring) = (points.len() as u32 - 1, columns as u32);
    let mut corners = Vec::new();
    for column in 0..ring {
        let next = (column + 1) % ring;
        corners.extend([0, 1 + next, 1 + column]);
        for row in 0..n as u32 - 2 {
            let [a, b] = [column, next].map(|c| 1 + row * ring + c);
            corners.extend([a, b, b + ring, a, b + ring, a + ring]);
        }
        corners.extend([last, last - ring + column, last - ring + next]);
    }
    (points, corners)
}

/// A glTF under construction: meshes, then nodes and more as JSON.
#[derive(Default)]
pub(crate) struct Scene {
    pub(crate) bytes: Vec<u8>,
    pub(crate) views: Vec<Value>,
    pub(crate) accessors: Vec<Value>,
    pub(crate) meshes: Vec<Value>,
}

impl Scene {
    pub(crate) fn of_rocks(sizes: &[usize]) -> Self {
        let mut scene = Self::default();
        for (i, &n) in sizes.iter().enumerate() {
            let (points, corners) = rock(n, i as f64);
            let numbers: Vec<f32> = points.iter().flatten().map(|&c| c as f32).collect();
            scene.mesh(&format!("rock{i}"), &numbers, &corners);
        }
        scene
    }

    /// Adds a mesh: three numbers for each vertex, three corners for each triangle.
    pub(crate) fn mesh(&mut self, name: &str, numbers: &[f32], corners: &[u32]) {
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..3)
                .map(|k| numbers.iter().skip(k).step_by(3).copied().reduce(pick).expect("one"))
                .collect()
        };
        let (low, high) = (bound(f32::min), bound(f32::max));
        let positions = self.floats(numbers, "VEC3");
        self.accessors[positions]["min"] = json!(low);
        self.accessors[positions]["max"] = json!(high);
        let indices: Vec<u8> = corners.iter().flat_map(|i| i.to_le_bytes()).collect();
        let indices = self.accessor(&indices, 5125, corners.len(), "SCALAR");
        let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices});
        self.meshes.push(json!({"name": name, "primitives": [primitive]}));
    }

    pub(crate) fn floats(&mut self, numbers: &[f32], kind: &str) -> usize {
        let width = match kind {
            "VEC4" => 4,
            "VEC3" => 3,
            "VEC2" => 2,
            _ => 1,
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, numbers.len() / width, kind)
    }

    pub(crate) fn accessor(
        &mut self,
        bytes: &[u8],
        component: u32,
        count: usize,
        kind: &str,
    ) -> usize {
        let view = self.view(bytes);
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind}));
        self.accessors.len() - 1
    }

    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.views.push(view);
        self.bytes.extend(bytes);
        self.views.len() - 1
    }

    /// The file; `more` has nodes, and animations if there are any.
    pub(crate) fn file(&self, roots: &[usize], more: &Value) -> String {
        let uri = format!("data:application/octet-stream;base64,{}", base64(&self.bytes));
        let mut file = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": roots}],
            "meshes": self.meshes, "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{"byteLength": self.bytes.len(), "uri": uri}]});
        for (key, value) in more.as_object().expect("keys") {
            file[key] = value.clone();
        }
        file.to_string()
    }
}

/// A folder with scene `s.gltf` and its levels `m.lodc`.
fn built(scene: &str) -> Folder {
    let f = Folder::new();
    f.file("s.gltf", scene);
    f.lodc(["build", "s.gltf", "-o", "m.lodc"]).ends(0);
    f
}

fn extract(f: &Folder, input: &str, output: &str, args: &[&str]) -> Value {
    let all = ["extract", input, "-o", output, "--json"];
    f.lodc(all.iter().chain(args)).ends(0).json()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The largest distance between the scene and a level of it, as `compare` measures it, and the root
/// mean square one.
fn compared(f: &Folder, level: &str, args: &[&str]) -> [f64; 2] {
    let all = ["compare", "s.gltf", level, "--json", "--views", "0"];
    let found = f.lodc(all.iter().chain(args)).ends(0).json();
    [number(&found["hausdorff"]["max"]), number(&found["rms"]["max"])]
}

/// Levels of the file and of the scene state what is measured, and `verify` agrees.
fn states_what_is_measured(scene: &str, poses: &[&[&str]]) {
    let f = built(scene);
    f.lodc(["verify", "m.lodc", "--source", "s.gltf"]).ends(0);
    for ratio in ["0.5", "0.1"] {
        for input in ["m.lodc", "s.gltf"] {
            let level = extract(&f, input, "level.glb", &["--ratio", ratio]);
            let stated = number(&level["error"]);
            let largest =
                poses.iter().map(|pose| compared(&f, "level.glb", pose)[0]).fold(0.0, f64::max);
            let what = format!("{input} at {ratio}: {stated} stated, {largest} measured");
            assert!(largest <= 1.05 * stated, "{what}");
            // Levels of a file never err less than finer ones.
            assert!(stated <= if input == "s.gltf" { 1.15 } else { 1.5 } * largest, "{what}");
            f.lodc(["verify", "level.glb", "--source", "s.gltf"]).ends(0);
        }
    }
    extract(&f, "s.gltf", "refitted.glb", &["--ratio", "0.2"]);
    f.lodc(["verify", "refitted.glb", "--source", "s.gltf"]).ends(0);
    f.lodc(["chain", "s.gltf", "-o", "chain.glb", "--quantize", "pos=14"]).ends(0);
    f.lodc(["verify", "chain.glb", "--source", "s.gltf"]).ends(0);
}

const AT_REST: &[&[&str]] = &[&[]];

#[test]
fn a_flat_shadow_does_not_hide_what_the_object_loses() {
    let nodes = json!([
        {"mesh": 0, "scale": [1.0, 0.001, 1.0], "translation": [0, -2, 0]},
        {"mesh": 0, "scale": [0.95, 0.95, 0.95]}]);
    states_what_is_measured(
        &Scene::of_rocks(&[12]).file(&[0, 1], &json!({"nodes": nodes})),
        AT_REST,
    );
}

#[test]
fn the_worst_of_unlike_and_sheared_placements_counts() {
    let mut nodes = Vec::new();
    for i in 0..8 {
        let angle = f64::from(i) * 0.7;
        let turn = |a: f64, b: f64| {
            let [s, c] = [(a / 2.0).sin(), (a / 2.0).cos()];
            [s * b.cos(), s * b.sin(), 0.0, c]
        };
        nodes.push(json!({"scale": [4.0, 0.25, 1.0], "rotation": turn(angle, 1.0),
            "translation": [12.0 * f64::from(i), 0.0, 0.0], "children": [2 * i + 1]}));
        nodes.push(
            json!({"mesh": 0, "scale": [-1.0, 0.3, 2.0], "rotation": turn(2.0 * angle, 0.3)}),
        );
    }
    let roots: Vec<usize> = (0..8).map(|i| 2 * i).collect();
    states_what_is_measured(
        &Scene::of_rocks(&[12]).file(&roots, &json!({"nodes": nodes})),
        AT_REST,
    );
}

/// An animation of the scale of a node, from `from` to 1 at half a second and back.
fn pops(scene: &mut Scene, node: usize, from: f32) -> Value {
    let times = scene.floats(&[0.0, 0.5, 1.0], "SCALAR");
    scene.accessors[times]["min"] = json!([0.0]);
    scene.accessors[times]["max"] = json!([1.0]);
    let values = [from, 1.0, from].map(|s| [s; 3]).concat();
    let values = scene.floats(&values, "VEC3");
    json!([{"name": "pop", "samplers": [{"input": times, "output": values}],
            "channels": [{"sampler": 0, "target": {"node": node, "path": "scale"}}]}])
}

#[test]
fn an_object_that_grows_counts_as_large_as_it_becomes() {
    for from in [0.001, 0.0] {
        let mut scene = Scene::of_rocks(&[12, 12]);
        let animations = pops(&mut scene, 1, from);
        let nodes = json!([{"mesh": 0},
            {"mesh": 1, "translation": [3, 0, 0], "scale": [from, from, from]}]);
        let scene = scene.file(&[0, 1], &json!({"nodes": nodes, "animations": animations}));
        states_what_is_measured(&scene, &[&[], &["--pose", "pop@0.5"]]);
        let f = built(&scene);
        let level = extract(&f, "m.lodc", "half.glb", &["--ratio", "0.5"]);
        let of = |i: usize| number(&level["objects"][i]["triangles"]);
        assert!((of(1) / of(0) - 1.0).abs() < 0.3, "{level}");
    }
}

#[test]
fn an_object_that_turns_below_an_uneven_scale_is_bounded_between_keys() {
    let half_turn = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    let mut scene = Scene::of_rocks(&[12]);
    let times = scene.floats(&[0.0, 2.0], "SCALAR");
    scene.accessors[times]["min"] = json!([0.0]);
    scene.accessors[times]["max"] = json!([2.0]);
    let values = scene.floats(&half_turn, "VEC4");
    let animations = json!([{"name": "turn", "samplers": [{"input": times, "output": values}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}}]}]);
    let nodes = json!([{"scale": [3.0, 1.0, 1.0], "children": [1]}, {"mesh": 0}]);
    let scene = scene.file(&[0], &json!({"nodes": nodes, "animations": animations}));
    let f = built(&scene);
    f.lodc(["verify", "m.lodc", "--source", "s.gltf"]).ends(0);
    for args in [&["--ratio", "0.1"][..], &["--error", "0.5", "--no-refit"]] {
        let level = extract(&f, "s.gltf", "level.glb", args);
        let at = |i: u32| format!("turn@{}", f64::from(i) / 8.0);
        let measured = |i: u32| compared(&f, "level.glb", &["--pose", &at(i)])[0];
        let (largest, stated) =
            ((0..=16).map(measured).fold(0.0, f64::max), number(&level["error"]));
        assert!(largest <= 1.02 * stated, "{args:?}: {stated} stated, {largest} measured");
        assert!(stated <= 1.2 * largest, "{args:?}: {stated} stated, {largest} measured");
        f.lodc(["verify", "level.glb", "--source", "s.gltf"]).ends(0);
    }
    extract(&f, "s.gltf", "grid.glb", &["--ratio", "0.3", "--quantize", "pos=12"]);
    f.lodc(["verify", "grid.glb", "--source", "s.gltf"]).ends(0);
}

/// An animation of one second by a pointer (KHR_animation_pointer).
fn pointing(scene: &mut Scene, pointer: &str, values: &[f32], kind: &str) -> Value {
    let times = scene.floats(&[0.0, 1.0], "SCALAR");
    scene.accessors[times]["min"] = json!([0.0]);
    scene.accessors[times]["max"] = json!([1.0]);
    let values = scene.floats(values, kind);
    let extensions = json!({"KHR_animation_pointer": {"pointer": pointer}});
    json!([{"name": "go", "samplers": [{"input": times, "output": values}],
        "channels": [{"sampler": 0, "target": {"path": "pointer", "extensions": extensions}}]}])
}

#[test]
fn a_pointer_that_scales_a_node_counts_as_a_channel_does() {
    let mut scene = Scene::of_rocks(&[12]);
    let values = [1.0, 1.0, 1.0, 20.0, 20.0, 20.0];
    let animations = pointing(&mut scene, "/nodes/0/scale", &values, "VEC3");
    let more = json!({"nodes": [{"mesh": 0}], "animations": animations,
        "extensionsUsed": ["KHR_animation_pointer"]});
    states_what_is_measured(&scene.file(&[0], &more), &[&[], &["--pose", "go@1"]]);
}

#[test]
fn pointers_to_morph_weights_are_repeated_for_coarser_levels() {
    for pointer in ["/meshes/0/weights", "/nodes/0/weights", "/meshes/0/weights/0"] {
        let mut scene = Scene::of_rocks(&[12]);
        let (points, _) = rock(12, 0.0);
        let moved: Vec<f32> = points.iter().flat_map(|p| [0.0, p[0] as f32, 0.0]).collect();
        let target = scene.floats(&moved, "VEC3");
        scene.accessors[target]["min"] = json!([-2, -2, -2]);
        scene.accessors[target]["max"] = json!([2, 2, 2]);
        scene.meshes[0]["primitives"][0]["targets"] = json!([{"POSITION": target}]);
        let animations = pointing(&mut scene, pointer, &[0.0, 1.0], "SCALAR");
        let more = json!({"nodes": [{"mesh": 0}], "animations": animations,
            "extensionsUsed": ["KHR_animation_pointer"]});
        let f = Folder::new();
        f.file("s.gltf", scene.file(&[0], &more));
        for args in [&[][..], &["--geomorph"]] {
            let chain = ["chain", "s.gltf", "-o", "chain.gltf"];
            f.lodc(chain.iter().chain(args)).ends(0);
            f.lodc(["verify", "chain.gltf", "--source", "s.gltf"]).ends(0);
            let mut chain: Value = serde_json::from_slice(&f.read("chain.gltf")).expect("JSON");
            let levels = chain["nodes"].as_array().expect("nodes").len();
            let channels = chain["animations"][0]["channels"].as_array_mut().expect("channels");
            assert_eq!(channels.len(), levels, "{pointer}");
            // One that is missing is found.
            channels.pop();
            f.file("chain.gltf", chain.to_string());
            f.lodc(["verify", "chain.gltf", "--source", "s.gltf"]).ends(1);
        }
    }
}

#[test]
fn one_object_states_the_units_of_its_scene_as_two_do() {
    let mut one = Scene::of_rocks(&[12]);
    let rock = json!({"mesh": 0, "scale": [100, 100, 100]});
    let alone = built(&one.file(&[0], &json!({"nodes": [rock]})));
    // With a triangle beside it.
    let corners = one.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], "VEC3");
    one.accessors[corners]["min"] = json!([0, 0, 0]);
    one.accessors[corners]["max"] = json!([1, 1, 0]);
    one.meshes.push(json!({"primitives": [{"attributes": {"POSITION": corners}}]}));
    let two = built(&one.file(&[0, 1], &json!({"nodes": [rock, {"mesh": 1}]})));
    for args in [&["--error", "2"][..], &["--rms", "0.5"], &["--pixels", "1", "--distance", "2000"]]
    {
        let [a, b] = [&alone, &two].map(|f| extract(f, "m.lodc", "level.glb", args));
        assert_eq!(a["objects"][0], b["objects"][0], "{args:?}");
        assert_eq!([&a["error"], &a["rms"]], [&b["error"], &b["rms"]], "{args:?}");
        let own = &a["objects"][0];
        let ratio = number(&a["error"]) / number(&own["error"]);
        assert!((ratio / 100.0 - 1.0).abs() < 1e-12, "{a}");
        assert_eq!((&own["world_error"], &own["world_rms"]), (&a["error"], &a["rms"]));
        assert!(number(&own["triangles"]) < 528.0, "{a}");
        if args[0] == "--error" {
            assert!(number(&a["error"]) <= 2.0 && number(&a["error"]) > 0.5, "{a}");
            let [largest, _] = compared(&alone, "level.glb", &[]);
            assert!(largest <= 1.05 * number(&a["error"]));
        }
    }
    // By itself an object is measured in its own units.
    let own = extract(&alone, "m.lodc", "own.glb", &["--error", "0.02", "--per-object"]);
    let world = extract(&alone, "m.lodc", "world.glb", &["--error", "2"]);
    assert_eq!(own["objects"], world["objects"]);
    // Every command tells the same of a level, as it is stored.
    let plain = ["--error", "2", "--no-refit"];
    let error = number(&extract(&alone, "m.lodc", "world.glb", &plain)["error"]);
    let chain = ["chain", "m.lodc", "-o", "chain.glb", "--errors", "2", "--json"];
    let chain = alone.lodc(chain).ends(0).json();
    assert_eq!(number(&chain["levels"][0]["error"]), error);
    let info = alone.lodc(["info", "m.lodc", "--json"]).ends(0).json();
    for lod in info["objects"][0]["lods"].as_array().expect("levels") {
        for [world, own] in [["world_error", "error"], ["world_rms", "rms"]] {
            let [world, own] = [world, own].map(|name| number(&lod[name]));
            assert!((world - 100.0 * own).abs() <= 1e-12 * world, "{world} {own}");
        }
    }
    assert!(alone.lodc(["info", "m.lodc"]).ends(0).text().contains("in its own units"));
    let select = ["select", "m.lodc", "--pixels", "1", "--distance", "2000", "--json"];
    let select = alone.lodc(select).ends(0).json();
    let plain = ["--pixels", "1", "--distance", "2000", "--no-refit"];
    let level = extract(&alone, "m.lodc", "l.glb", &plain);
    assert_eq!(select["lod"], level["lod"]);
    let [selected, extracted] = [&select["error"], &level["error"]].map(number);
    assert!((selected - extracted).abs() <= 1e-6 * extracted, "{selected} {extracted}");
    // Distances of a chain are those at which errors, in the scene's units, are a pixel.
    let morphs = ["chain", "m.lodc", "-o", "geomorph.glb", "--geomorph", "--json"];
    let levels = alone.lodc(morphs).ends(0).json()["levels"].clone();
    let slope = 2.0 * (TAU / 12.0).tan() / 1080.0;
    for level in levels.as_array().expect("levels") {
        let expected = number(&level["error"]) / slope;
        assert!((number(&level["distance"]) - expected).abs() <= 1e-6 * expected, "{level}");
    }
    alone.lodc(["verify", "geomorph.glb", "--source", "s.gltf"]).ends(0);
}

/// The scene of one rock at a hundred instances of any widths and heights.
fn instanced(count: usize) -> String {
    let mut scene = Scene::of_rocks(&[12]);
    let of = |i: usize, k: usize| ((i * 7 + k * 13) % 31) as f32 / 31.0;
    let all = |one: &dyn Fn(usize) -> [f32; 3]| (0..count).flat_map(one).collect::<Vec<f32>>();
    let scales = scene.floats(&all(&|i| [0, 1, 2].map(|k| 0.5 + of(i, k))), "VEC3");
    let places = all(&|i| [4.0 * (i % 10) as f32, 0.0, 4.0 * (i / 10) as f32]);
    let places = scene.floats(&places, "VEC3");
    let attributes = json!({"TRANSLATION": places, "SCALE": scales});
    let nodes = json!([{"mesh": 0,
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}]);
    let used = json!(["EXT_mesh_gpu_instancing"]);
    scene.file(&[0], &json!({"nodes": nodes, "extensionsUsed": used}))
}

#[test]
fn instances_of_any_widths_and_heights_are_bounded() {
    let f = built(&instanced(100));
    for ratio in ["0.5", "0.1"] {
        let level = extract(&f, "m.lodc", "level.glb", &["--ratio", ratio]);
        let (stated, [largest, rms]) = (number(&level["error"]), compared(&f, "level.glb", &[]));
        assert!(largest <= 1.05 * stated, "{stated} stated, {largest} measured");
        assert!(stated <= 1.5 * largest, "{stated} stated, {largest} measured");
        assert!(rms <= 1.1 * number(&level["rms"]), "{level}: {rms}");
        f.lodc(["verify", "level.glb", "--source", "s.gltf"]).ends(0);
    }
    f.lodc(["verify", "m.lodc", "--source", "s.gltf"]).ends(0);
}

#[test]
fn a_level_that_states_too_little_of_one_placement_is_refused() {
    let nodes =
        json!([{"mesh": 0, "scale": [1.0, 0.001, 1.0]}, {"mesh": 0, "scale": [0.9, 0.9, 0.9]}]);
    let f = built(&Scene::of_rocks(&[12]).file(&[0, 1], &json!({"nodes": nodes})));
    for factor in [1.0, 0.6, 2.2] {
        extract(&f, "s.gltf", "level.gltf", &["--ratio", "0.2"]);
        let mut level: Value = serde_json::from_slice(&f.read("level.gltf")).expect("JSON");
        let error = &mut level["extras"]["lodc"]["error"];
        *error = json!(number(error) * factor);
        f.file("level.gltf", level.to_string());
        let run = f.lodc(["verify", "level.gltf", "--source", "s.gltf"]);
        run.ends(if factor == 1.0 { 0 } else { 1 });
    }
}

#[test]
fn a_share_of_unlike_objects_costs_no_more_error_than_it_has_to() {
    // A statue beside screws on a kilometre of ground.
    let mut nodes = vec![
        json!({"mesh": 0, "scale": [1.5, 1.5, 1.5]}),
        json!({"mesh": 1, "scale": [500.0, 20.0, 500.0], "translation": [0, -30, 0]}),
    ];
    for i in 0..30 {
        let at = [f64::from(i % 6) * 0.3 - 3.0, 0.0, f64::from(i / 6) * 0.3 + 3.0];
        nodes.push(json!({"mesh": 2, "scale": [0.02, 0.02, 0.02], "translation": at}));
    }
    let roots: Vec<usize> = (0..nodes.len()).collect();
    let scene = Scene::of_rocks(&[24, 30, 10]).file(&roots, &json!({"nodes": nodes}));
    let f = built(&scene);
    for ratio in ["0.6", "0.5", "0.4", "0.3", "0.1"] {
        let level = extract(&f, "m.lodc", "level.glb", &["--ratio", ratio]);
        let (error, triangles) = (number(&level["error"]), number(&level["triangles"]));
        if error == 0.0 {
            continue;
        }
        let within = (error / 1.1).to_string();
        let better = extract(&f, "m.lodc", "better.glb", &["--error", &within]);
        let needed = number(&better["triangles"]);
        assert!(
            needed > triangles,
            "{ratio}: {needed} triangles err by {within}, {triangles} by {error}"
        );
    }
}
