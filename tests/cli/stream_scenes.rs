//! Streams of scenes: wherever they are cut every object has its share, and a mesh shows early.

use crate::placements::Scene;
use crate::scenes::add_skin;
use crate::support::Folder;
use lodc_fixtures::{Rng, seeds};
use serde_json::{Value, json};

/// Percent of a stream.
const CUTS: [usize; 4] = [10, 25, 50, 90];

/// A scene of rocks: few or many, alike or not in triangles and in size.
fn rocks(kind: u64) -> String {
    let mut rng = Rng::new(kind);
    let objects = [2, 5, 12, 25, 50][kind as usize % 5];
    let rows = |i: usize, rng: &mut Rng| match kind / 5 {
        0 => 8,
        1 => 5 + rng.below(10),
        2 => 8 << (i % 3),
        _ => [6, 24][usize::from(i == 0)],
    };
    let sizes: Vec<usize> = (0..objects).map(|i| rows(i, &mut rng)).collect();
    let node = |i: usize, rng: &mut Rng| {
        let scale = match kind % 4 {
            0 => 1.0,
            1 => 10.0_f32.powf(2.0 * rng.unit() - 1.0),
            2 => [1.0, 2.0, 4.0, 8.0, 16.0][i % 5],
            _ => 0.5 + rng.unit(),
        };
        let scales = [scale; 3];
        let place = [40.0 * (i % 7) as f32, 0.0, 40.0 * (i / 7) as f32];
        json!({"mesh": i, "name": format!("rock{i}"), "scale": scales, "translation": place})
    };
    let nodes: Vec<Value> = (0..objects).map(|i| node(i, &mut rng)).collect();
    let roots: Vec<usize> = (0..objects).collect();
    Scene::of_rocks(&sizes).file(&roots, &json!({"nodes": nodes}))
}

/// The largest world error of a report's objects, and triangles of all.
fn shown(report: &Value) -> (f64, u64) {
    let objects = report["objects"].as_array().expect("objects");
    let error = |o: &Value| o["world_error"].as_f64().unwrap_or(f64::INFINITY);
    let triangles = objects.iter().map(|o| o["triangles"].as_u64().expect("a number")).sum();
    (objects.iter().map(error).fold(0.0, f64::max), triangles)
}

fn hausdorff(f: &Folder, level: &str) -> f64 {
    let found = f.lodc(["compare", "s.gltf", level, "--json", "--views", "0"]).ends(0).json();
    found["hausdorff"]["max"].as_f64().expect("a distance")
}

#[test]
fn every_object_has_its_share_of_a_stream_that_is_cut() {
    for kind in seeds(3, 8).map(|seed| 7 * seed % 20) {
        let f = Folder::new();
        f.file("s.gltf", rocks(kind));
        f.lodc(["build", "s.gltf", "-o", "m.lodc", "--models", "none", "-q"]).ends(0);
        f.lodc(["pack", "m.lodc", "-o", "m.lods", "-q"]).ends(0);
        let stream = f.read("m.lods");
        for percent in CUTS {
            f.file("cut.lods", &stream[..stream.len() * percent / 100]);
            let unpack = ["unpack", "cut.lods", "-o", "cut.glb", "--json"];
            let (error, triangles) = shown(&f.lodc(unpack).ends(0).json());
            let budget = triangles.to_string();
            let extract = ["extract", "m.lodc", "--triangles", &budget, "--no-refit"];
            let extract = extract.iter().chain(&["-o", "level.glb", "--json"]);
            let (wanted, _) = shown(&f.lodc(extract).ends(0).json());
            let what = format!("scene {kind}, {percent} %, {triangles} triangles");
            assert!(error <= 1.5 * wanted, "{what}: {error} for {wanted}");
            let [error, wanted] = ["cut.glb", "level.glb"].map(|level| hausdorff(&f, level));
            assert!(error <= 1.5 * wanted, "{what}: {error} for {wanted} measured");
        }
    }
}

/// A rock with a skin of so many joints, which an animation moves, turns and scales.
fn rig(rows: usize, joints: usize) -> String {
    let mut scene = Scene::of_rocks(&[rows]);
    let skins = add_skin(&mut scene, joints, 1);
    let times = scene.floats(&[0.0, 0.5, 1.0], "SCALAR");
    scene.accessors[times]["min"] = json!([0.0]);
    scene.accessors[times]["max"] = json!([1.0]);
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for joint in 1..=joints {
        for path in ["translation", "rotation", "scale"] {
            let angle = |k: f64| (0.1 * k * joint as f64).sin() as f32;
            let output = if path == "rotation" {
                let turned = |k: f64| [angle(k), 0.0, 0.0, (1.0 - angle(k) * angle(k)).sqrt()];
                scene.floats([0.0, 0.5, 1.0].map(turned).as_flattened(), "VEC4")
            } else {
                let moved = |k: f64| [1.0 + angle(k), 1.0, 1.0 - 0.1 * angle(k)];
                scene.floats([0.0, 0.5, 1.0].map(moved).as_flattened(), "VEC3")
            };
            let target = json!({"node": joint, "path": path});
            channels.push(json!({"sampler": samplers.len(), "target": target}));
            samplers.push(json!({"input": times, "output": output, "interpolation": "LINEAR"}));
        }
    }
    let mut nodes = vec![json!({"mesh": 0, "skin": 0, "name": "Proxy"})];
    nodes.extend((1..=joints).map(|j| json!({"name": format!("torso_joint_{j}")})));
    let roots: Vec<usize> = (0..=joints).collect();
    let animations = json!([{"channels": channels, "samplers": samplers}]);
    scene.file(&roots, &json!({"nodes": nodes, "skins": skins, "animations": animations}))
}

#[test]
fn rigs_of_many_nodes_show_a_mesh_at_a_twentieth() {
    for (rows, joints) in [(10, 19), (14, 60), (24, 120), (40, 8)] {
        let f = Folder::new();
        f.file("s.gltf", rig(rows, joints));
        f.lodc(["build", "s.gltf", "-o", "m.lodc", "--models", "none", "--poses", "0", "-q"])
            .ends(0);
        f.lodc(["pack", "m.lodc", "-o", "m.lods", "-q"]).ends(0);
        let stream = f.read("m.lods");
        f.file("cut.lods", &stream[..stream.len() / 20]);
        let report = f.lodc(["unpack", "cut.lods", "-o", "cut.glb", "--json"]).ends(0).json();
        let (error, triangles) = shown(&report);
        assert!(triangles >= 2 && error.is_finite(), "{joints} joints: {triangles} triangles");
        // What is shown is a mesh that others read, and all of it comes in the end.
        f.lodc(["compare", "cut.glb", "cut.glb", "--views", "0"]).ends(0);
        let report = f.lodc(["unpack", "m.lods", "-o", "all.glb", "--whole", "--json"]).ends(0);
        assert_eq!(report.json()["left_out"], json!([]));
    }
}
