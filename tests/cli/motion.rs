//! Levels in motion: what morph targets and joints move is priced, and what only lies together at
//! rest is not one.

use crate::placements::Scene;
use crate::scenes::{add_targets, moving_weights};
use crate::support::Folder;
use serde_json::{Value, json};

/// Quads along each side of the grid.
const SIDE: usize = 20;

/// A grid of triangles, and what moves it.
#[derive(Default)]
struct Model {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// The deltas of a morph target, and its weight by default.
    target: Option<(Vec<[f32; 3]>, f32)>,
    /// For each vertex which of two joints leads it. The second turns in an animation.
    joint: Option<Vec<u8>>,
}

impl Model {
    /// A gently curved sheet, from 0 to 1 along x and y.
    fn sheet() -> Self {
        let at = |i: usize| [i % (SIDE + 1), i / (SIDE + 1)].map(|k| k as f32 / SIDE as f32);
        let height = |[x, y]: [f32; 2]| 0.05 * (3.0 * x).sin() * (2.0 * y).cos();
        let positions = (0..(SIDE + 1) * (SIDE + 1)).map(|i| {
            let [x, y] = at(i);
            [x, y, height([x, y])]
        });
        let corner = |i: usize, j: usize| (j * (SIDE + 1) + i) as u32;
        let quad = |q: usize| {
            let (i, j) = (q % SIDE, q / SIDE);
            let [a, b, c, d] =
                [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        let triangles = (0..SIDE * SIDE).flat_map(quad).collect();
        Self { positions: positions.collect(), triangles, ..Self::default() }
    }

    /// The sheet with a slit along its middle row, whose lower vertices come last. Also says which
    /// vertices are below it.
    fn slit() -> (Self, Vec<bool>) {
        let mut model = Self::sheet();
        let row = SIDE / 2;
        let mut below: Vec<bool> =
            (0..model.positions.len()).map(|v| v / (SIDE + 1) < row).collect();
        for i in 5..SIDE - 4 {
            let (upper, lower) = ((row * (SIDE + 1) + i) as u32, model.positions.len() as u32);
            model.positions.push(model.positions[upper as usize]);
            below.push(true);
            for t in model.triangles.iter_mut().take(2 * SIDE * row) {
                *t = t.map(|v| if v == upper { lower } else { v });
            }
        }
        (model, below)
    }

    /// The deltas that pull what is below the slit down.
    fn opening(&self, below: &[bool]) -> Vec<[f32; 3]> {
        let pull = |([x, y, _], below): (&[f32; 3], &bool)| {
            let near = (-20.0 * ((x - 0.5).powi(2) + (y - 0.5).powi(2))).exp();
            [0.0, if *below { -0.3 * near } else { 0.0 }, 0.0]
        };
        self.positions.iter().zip(below).map(pull).collect()
    }

    /// The same with the target's deltas in its positions.
    fn moved(&self) -> Self {
        let deltas = &self.target.as_ref().expect("a target").0;
        let add = |(p, d): (&[f32; 3], &[f32; 3])| [p[0] + d[0], p[1] + d[1], p[2] + d[2]];
        let positions = self.positions.iter().zip(deltas).map(add).collect();
        Self { positions, triangles: self.triangles.clone(), ..Self::default() }
    }

    /// The model as a GLB file.
    fn glb(&self) -> Vec<u8> {
        let (mut bytes, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
        let mut add = |data: Vec<u8>, component: u32, kind: &str, count: usize, more: Value| {
            bytes.resize(usize::next_multiple_of(bytes.len(), 4), 0u8);
            views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len()}));
            bytes.extend(data);
            let mut accessor = json!({"bufferView": views.len() - 1, "componentType": component,
                "type": kind, "count": count});
            accessor
                .as_object_mut()
                .expect("an object")
                .extend(more.as_object().cloned().unwrap_or_default());
            accessors.push(accessor);
            accessors.len() - 1
        };
        let floats = |all: &[f32]| all.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let bounds = |all: &[[f32; 3]]| {
            let of = |pick: fn(f32, f32) -> f32| {
                let all = all.iter().copied();
                all.reduce(|a, b| std::array::from_fn(|k| pick(a[k], b[k]))).expect("vertices")
            };
            json!({"min": of(f32::min), "max": of(f32::max)})
        };
        let count = self.positions.len();
        let mut vectors =
            |all: &[[f32; 3]]| add(floats(all.as_flattened()), 5126, "VEC3", count, bounds(all));
        let position = vectors(&self.positions);
        let target = self.target.as_ref().map(|(deltas, _)| vectors(deltas));
        let corners = self.triangles.as_flattened();
        let indices = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
        let indices = add(indices, 5125, "SCALAR", corners.len(), json!({}));
        let mut primitive = json!({"attributes": {"POSITION": position}, "indices": indices});
        if let Some(target) = target {
            primitive["targets"] = json!([{"POSITION": target}]);
        }
        let mut document = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
        });
        if let Some(joints) = &self.joint {
            let of = |&joint: &u8| [joint, 0, 0, 0];
            let joints = add(joints.iter().flat_map(of).collect(), 5121, "VEC4", count, json!({}));
            let one = [1.0f32, 0.0, 0.0, 0.0].repeat(count);
            let weights = add(floats(&one), 5126, "VEC4", count, json!({}));
            primitive["attributes"]["JOINTS_0"] = json!(joints);
            primitive["attributes"]["WEIGHTS_0"] = json!(weights);
            let times = json!({"min": [0.0], "max": [1.0]});
            let times = add(floats(&[0.0, 1.0]), 5126, "SCALAR", 2, times);
            let turned = [0.0, 0.0, 0.0, 1.0, 0.25881904, 0.0, 0.0, 0.9659258];
            let turns = add(floats(&turned), 5126, "VEC4", 2, json!({}));
            document["nodes"] = json!([{"mesh": 0, "skin": 0}, {"children": [2]}, {}]);
            document["scenes"][0]["nodes"] = json!([0, 1]);
            document["skins"] = json!([{"joints": [1, 2]}]);
            document["animations"] = json!([{
                "samplers": [{"input": times, "output": turns}],
                "channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}}],
            }]);
        }
        let weights: Vec<f32> = self.target.iter().map(|(_, weight)| *weight).collect();
        document["meshes"] = json!([{"primitives": [primitive]}]);
        if !weights.is_empty() {
            document["meshes"][0]["weights"] = json!(weights);
        }
        bytes.resize(usize::next_multiple_of(bytes.len(), 4), 0);
        document["buffers"] = json!([{"byteLength": bytes.len()}]);
        (document["bufferViews"], document["accessors"]) = (json!(views), json!(accessors));
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let word = |n: usize| (n as u32).to_le_bytes();
        let total = 28 + text.len() + bytes.len();
        let chunk = |kind: &[u8], data: Vec<u8>| [&word(data.len())[..], kind, &data[..]].concat();
        let header = [&b"glTF"[..], &word(2)[..], &word(total)[..]].concat();
        [header, chunk(b"JSON", text), chunk(b"BIN\0", bytes)].concat()
    }
}

/// A level of a file: its error and triangles.
fn level(f: &Folder, name: &str, ratio: &str) -> (f64, u64) {
    let args = ["extract", name, "-o", "level.glb", "--ratio", ratio, "--no-refit", "--json"];
    let report = f.lodc(args).ends(0).json();
    (report["error"].as_f64().expect("a number"), report["triangles"].as_u64().expect("a number"))
}

/// Takes a model through files, streams, chains and refitting, each of which is verified.
fn holds_everywhere(f: &Folder, name: &str) {
    f.lodc(["build", name, "-o", "m.lodc", "-q"]).ends(0);
    f.lodc(["verify", "m.lodc", "--source", name, "-q"]).ends(0);
    f.lodc(["verify", "m.lodc", "--gpu=auto", "-q"]).ends(0);
    f.lodc(["pack", "m.lodc", "-o", "m.lods", "-q"]).ends(0);
    f.lodc(["unpack", "m.lods", "-o", "unpacked.lodc", "-q"]).ends(0);
    f.lodc(["verify", "unpacked.lodc", "-q"]).ends(0);
    f.lodc(["chain", name, "-o", "chain.glb", "--auto", "4", "--geomorph", "-q"]).ends(0);
    f.lodc(["verify", "chain.glb", "--source", name, "-q"]).ends(0);
    f.lodc(["extract", name, "-o", "refitted.glb", "--ratio", "0.4", "-q"]).ends(0);
    f.lodc(["verify", "refitted.glb", "--source", name, "-q"]).ends(0);
}

#[test]
fn a_bump_that_a_target_raises_is_kept_as_if_it_were_there() {
    let f = Folder::new();
    let mut model = Model::sheet();
    let bump = |[x, y, _]: &[f32; 3]| {
        [0.0, 0.0, 0.2 * (-60.0 * ((x - 0.4).powi(2) + (y - 0.6).powi(2))).exp()]
    };
    model.target = Some((model.positions.iter().map(bump).collect(), 0.0));
    f.file("static.glb", model.moved().glb());
    for weight in [0.0, 1.0] {
        model.target.as_mut().expect("a target").1 = weight;
        f.file("m.glb", model.glb());
        for ratio in ["0.5", "0.25"] {
            let (error, still) = (level(&f, "m.glb", ratio).0, level(&f, "static.glb", ratio).0);
            assert!(error < 1.5 * still, "{error} {still} at {ratio}, weight {weight}");
            // At rest alone the bump is not known of.
            let rest = ["extract", "m.glb", "-o", "r.glb", "--ratio", ratio, "--poses", "0"];
            f.lodc(rest).ends(0);
        }
    }
    holds_everywhere(&f, "m.glb");
}

#[test]
fn lips_that_touch_at_rest_are_not_webbed() {
    let f = Folder::new();
    let (mut model, below) = Model::slit();
    model.target = Some((model.opening(&below), 0.0));
    f.file("m.glb", model.glb());
    f.file("open.glb", model.moved().glb());
    for ratio in ["0.9", "0.5"] {
        let (error, open) = (level(&f, "m.glb", ratio).0, level(&f, "open.glb", ratio).0);
        assert!(error < 1.5 * open, "{error} {open} at {ratio}");
    }
    holds_everywhere(&f, "m.glb");
    let (mut model, below) = Model::slit();
    model.joint = Some(below.iter().map(|&below| u8::from(below)).collect());
    f.file("jaw.glb", model.glb());
    holds_everywhere(&f, "jaw.glb");
}

#[test]
fn triangles_that_are_a_point_at_rest_alone_stay() {
    let f = Folder::new();
    let mut model = Model::sheet();
    let folded = |p: &[f32; 3]| if p[1] > 0.3 { [0.5, 0.3, 0.0] } else { *p };
    let at_rest: Vec<[f32; 3]> = model.positions.iter().map(folded).collect();
    let deltas = model.positions.iter().zip(&at_rest);
    let deltas = deltas.map(|(p, q)| std::array::from_fn(|k| p[k] - q[k])).collect();
    (model.positions, model.target) = (at_rest, Some((deltas, 1.0)));
    f.file("m.glb", model.glb());
    f.file("unfolded.glb", model.moved().glb());
    let all = model.triangles.len() as u64;
    assert_eq!(level(&f, "m.glb", "1"), (0.0, all));
    let (error, open) = (level(&f, "m.glb", "0.5").0, level(&f, "unfolded.glb", "0.5").0);
    assert!(error < 1.5 * open, "{error} {open}");
    holds_everywhere(&f, "m.glb");
}

#[test]
fn what_a_joint_bends_is_priced_as_it_bends() {
    let f = Folder::new();
    let mut model = Model::sheet();
    // A crease along which the animation folds the flat sheet.
    model.positions.iter_mut().for_each(|p| p[2] = 0.0);
    model.joint = Some(model.positions.iter().map(|p| u8::from(p[1] > 0.52)).collect());
    f.file("m.glb", model.glb());
    let (error, _) = level(&f, "m.glb", "0.1");
    assert!(error < 0.01, "{error}");
    holds_everywhere(&f, "m.glb");
}

/// A GLB with other default weights of its first mesh.
fn with_weights(glb: &[u8], weights: &[f64]) -> Vec<u8> {
    let length = u32::from_le_bytes(glb[12..16].try_into().expect("four bytes")) as usize;
    let (json, rest) = glb[20..].split_at(length);
    let mut document: Value = serde_json::from_slice(json).expect("a document");
    document["meshes"][0]["weights"] = json!(weights);
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let word = |n: usize| (n as u32).to_le_bytes();
    let total = 20 + text.len() + rest.len();
    let header = [&glb[..8], &word(total)[..], &word(text.len())[..], &b"JSON"[..]].concat();
    [header, text, rest.to_vec()].concat()
}

#[test]
fn what_morphs_spoils_no_shape() {
    let f = Folder::new();
    let (mut model, below) = Model::slit();
    model.target = Some((model.opening(&below), 0.0));
    f.file("m.glb", model.glb());
    f.file("open.glb", model.moved().glb());
    let chain = ["chain", "m.glb", "-o", "c.glb", "--separate", "--geomorph", "--json"];
    let report = f.lodc(chain).ends(0).json();
    let far = |glb: &[u8], weights: &[f64], other: &str| {
        f.file("w.glb", with_weights(glb, weights));
        let report = f.lodc(["compare", other, "w.glb", "--json", "-q"]).ends(0).json();
        report["hausdorff"]["max"].as_f64().expect("a number")
    };
    let level = |k: usize| &report["levels"][k];
    let mut staying = 0;
    for k in 0..3 {
        let name = format!("c_LOD{k}.glb");
        f.lodc(["verify", &name, "--source", "m.glb", "-q"]).ends(0);
        let glb = f.read(&name);
        let limit = 1.25 * level(k + 1)["error"].as_f64().expect("a number") + 1e-4;
        for (weights, other) in [([0.0, 1.0], "m.glb"), ([1.0, 1.0], "open.glb")] {
            let far = far(&glb, &weights, other);
            assert!(far <= limit, "level {k} with {weights:?}: {far}, {limit}");
        }
        staying += level(k)["geomorph_staying"].as_u64().expect("a number");
        // More than half of it moves.
        let vertices = |k: usize| level(k)["vertices"].as_u64().expect("a number");
        let stay = level(k)["geomorph_staying"].as_u64().expect("a number");
        assert!(2 * stay < vertices(k) - vertices(k + 1), "{stay}");
    }
    assert!(staying > 0);
    // Nobody else may say that vertices stay.
    let shared = ["chain", "m.glb", "-o", "s.gltf", "--geomorph", "-q"];
    f.lodc(shared).ends(0);
    let text = String::from_utf8(f.read("s.gltf")).expect("text");
    f.lodc(["verify", "s.gltf", "--source", "m.glb", "-q"]).ends(0);
    f.file("t.gltf", text.replace("geomorph_staying", "geomorph_stays"));
    let run = f.lodc(["verify", "t.gltf"]).ends(1);
    assert!(run.text().contains("morph into the next level, cpu: DIFFERENT"), "{}", run.text());
}

#[test]
fn a_fan_that_is_folded_at_rest_is_measured_where_it_opens() {
    let f = Folder::new();
    // All of it lies on a curve: its area is that of the first faces that are not folded up.
    let parabola = |[x, _, _]: [f32; 3]| [x, 0.2 * x * x, 0.0];
    let helix = |[x, _, _]: [f32; 3]| [0.2 * (9.0 * x).cos(), 0.2 * (9.0 * x).sin(), x];
    let almost = |[x, y, _]: [f32; 3]| [(5.0 * x).cos(), (5.0 * x).sin(), 1e-7 * (1e4 * y).sin()];
    let curves: [fn([f32; 3]) -> [f32; 3]; 3] = [parabola, helix, almost];
    for curve in curves {
        let mut model = Model::sheet();
        let at_rest: Vec<[f32; 3]> = model.positions.iter().map(|&p| curve(p)).collect();
        let deltas = model.positions.iter().zip(&at_rest);
        let deltas = deltas.map(|(p, q)| std::array::from_fn(|k| p[k] - q[k])).collect();
        (model.positions, model.target) = (at_rest, Some((deltas, 0.0)));
        f.file("m.glb", model.glb());
        let (error, _) = level(&f, "m.glb", "0.5");
        assert!(error < 0.03, "{error}");
        let refit = ["extract", "m.glb", "-o", "r.glb", "--ratio", "0.5", "--json"];
        let refitted = f.lodc(refit).ends(0).json()["error"].as_f64().expect("a finite number");
        assert!(refitted <= 1.06 * error, "{refitted} {error}");
        holds_everywhere(&f, "m.glb");
    }
}

#[test]
fn weights_that_move_in_another_node_count() {
    let f = Folder::new();
    let mut scene = Scene::of_rocks(&[12]);
    add_targets(&mut scene, 2);
    let mut animations = moving_weights(&mut scene, 2);
    animations[0]["channels"][0]["target"]["node"] = json!(1);
    let nodes = json!([{"mesh": 0}, {"mesh": 0, "weights": [3.0, -2.0], "translation": [3, 0, 0]}]);
    let more = json!({"nodes": nodes, "animations": animations});
    f.file("m.gltf", scene.file(&[0, 1], &more));
    for ratio in ["0.5", "0.1"] {
        let (error, _) = level(&f, "m.gltf", ratio);
        for pose in ["0@0.5", "0@1"] {
            let compare = ["compare", "m.gltf", "level.glb", "--pose", pose, "--json", "-q"];
            let report = f.lodc(compare).ends(0).json();
            let far = report["hausdorff"]["max"].as_f64().expect("a number");
            assert!(far <= 1.05 * error, "{far} at {pose}, {error} stated at {ratio}");
        }
    }
    holds_everywhere(&f, "m.gltf");
}
