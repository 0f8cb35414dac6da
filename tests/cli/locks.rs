//! What is locked stays: at every level, plain and refitted. Vertices that levels share, cards that
//! go whole, flat faces that stay flat.

use crate::support::{Folder, base64};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// A glTF of meshes, each of positions, other attributes by their names, and corners.
struct Scene {
    bytes: Vec<u8>,
    json: Value,
}

/// An attribute: its name and its values, one row for each vertex.
type Rows<'a> = (&'a str, &'a [Vec<f32>]);

impl Scene {
    fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
            "meshes": [], "accessors": [], "bufferViews": []});
        Self { bytes: Vec::new(), json }
    }

    fn push(&mut self, list: &str, entry: Value) -> usize {
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(entry);
        list.len() - 1
    }

    fn accessor(&mut self, bytes: Vec<u8>, mut accessor: Value) -> usize {
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.bytes.extend(bytes);
        let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
        accessor["bufferView"] = self.push("bufferViews", view).into();
        self.push("accessors", accessor)
    }

    /// Adds a mesh and a node that shows it; `node` has what else the node says.
    fn add(&mut self, name: &str, attributes: &[Rows<'_>], corners: &[u32], mut node: Value) {
        let mut primitive = json!({"attributes": {}});
        for (name, rows) in attributes {
            let bytes = rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
            let kind = if rows[0].len() == 2 { "VEC2" } else { "VEC3" };
            let mut accessor = json!({"componentType": 5126, "count": rows.len(), "type": kind});
            let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
                (0..rows[0].len())
                    .map(|k| rows.iter().map(|row| row[k]).reduce(pick).expect("a row"))
                    .collect()
            };
            accessor["min"] = bound(f32::min).into();
            accessor["max"] = bound(f32::max).into();
            primitive["attributes"][name] = self.accessor(bytes, accessor).into();
        }
        let bytes = corners.iter().flat_map(|i| i.to_le_bytes()).collect();
        let accessor = json!({"componentType": 5125, "count": corners.len(), "type": "SCALAR"});
        primitive["indices"] = self.accessor(bytes, accessor).into();
        let mesh = json!({"name": name, "primitives": [primitive]});
        node["mesh"] = self.push("meshes", mesh).into();
        node["name"] = name.into();
        let number = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("nodes").push(number.into());
    }

    fn text(mut self) -> String {
        let uri = format!("data:application/octet-stream;base64,{}", base64(&self.bytes));
        self.json["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        self.json.to_string()
    }
}

fn height(x: f64, y: f64) -> f64 {
    0.2 * (2.1 * x + 0.3).sin() * (1.7 * y).cos() + 0.03 * (9.0 * x + 7.0 * y).sin()
}

const TILE: usize = 12;

/// A tile of a hilly ground, one unit wide, with its first corner at `(x, y)`.
fn tile(x: usize, y: usize) -> (Vec<Vec<f32>>, Vec<u32>) {
    let at = |i: usize, first: usize| first as f64 + i as f64 / TILE as f64;
    let mut points = Vec::new();
    for j in 0..=TILE {
        for i in 0..=TILE {
            let (px, py) = (at(i, x), at(j, y));
            points.push([px, py, height(px, py)].map(|c| c as f32).to_vec());
        }
    }
    let mut corners = Vec::new();
    for j in 0..TILE {
        for i in 0..TILE {
            let a = (j * (TILE + 1) + i) as u32;
            let above = a + TILE as u32 + 1;
            corners.extend([a, a + 1, above + 1, a, above + 1, above]);
        }
    }
    (points, corners)
}

fn tiles(which: &[(usize, usize)]) -> String {
    let mut scene = Scene::new();
    for &(x, y) in which {
        let (points, corners) = tile(x, y);
        scene.add(&format!("tile{x}{y}"), &[("POSITION", &points)], &corners, json!({}));
    }
    scene.text()
}

const FOUR: [(usize, usize); 4] = [(0, 0), (1, 0), (0, 1), (1, 1)];

/// The edges with one face of an OBJ, by the positions of their ends.
fn borders(obj: &[u8]) -> BTreeSet<[[String; 3]; 2]> {
    let text = String::from_utf8(obj.to_vec()).expect("text");
    let mut points: Vec<[String; 3]> = Vec::new();
    let mut edges: BTreeMap<[[String; 3]; 2], u32> = BTreeMap::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["v", x, y, z, ..] => points.push([x, y, z].map(str::to_owned)),
            ["f", a, b, c] => {
                let corner = |word: &str| -> [String; 3] {
                    let number: usize =
                        word.split('/').next().expect("a number").parse().expect("a number");
                    points[number - 1].clone()
                };
                let corners = [a, b, c].map(corner);
                for k in 0..3 {
                    let mut edge = [corners[k].clone(), corners[(k + 1) % 3].clone()];
                    edge.sort();
                    *edges.entry(edge).or_default() += 1;
                }
            }
            _ => {}
        }
    }
    edges.into_iter().filter(|(_, faces)| *faces == 1).map(|(edge, _)| edge).collect()
}

#[test]
fn tiles_simplified_apart_meet_without_a_gap() {
    let f = Folder::new();
    for (x, y) in FOUR {
        f.file(&format!("t{x}{y}.gltf"), tiles(&[(x, y)]));
    }
    f.file("whole.gltf", tiles(&FOUR));
    f.lodc(["extract", "whole.gltf", "--ratio", "1", "-o", "whole.obj", "-q"]).ends(0);
    let outside = borders(&f.read("whole.obj"));
    assert_eq!(outside.len(), 8 * TILE, "four tiles that meet");
    for refit in [&[][..], &["--refit"]] {
        for (x, y) in FOUR {
            let name = format!("t{x}{y}");
            let args =
                ["chain", &format!("{name}.gltf"), "-o", &format!("{name}.obj"), "--separate"];
            let more = ["--lock-border", "--levels", "100%,60%,40%,20%", "-q"];
            f.lodc(args.iter().chain(&more).chain(refit)).ends(0);
        }
        for level in 0..4 {
            // Every border edge of one tile is that of another, or outside.
            let mut seen: BTreeMap<[[String; 3]; 2], u32> = BTreeMap::new();
            for (x, y) in FOUR {
                for edge in borders(&f.read(&format!("t{x}{y}_LOD{level}.obj"))) {
                    *seen.entry(edge).or_default() += 1;
                }
            }
            let unmatched = seen.into_iter().filter(|(_, tiles)| *tiles == 1).map(|(edge, _)| edge);
            let unmatched: BTreeSet<_> = unmatched.collect();
            assert_eq!(unmatched, outside, "level {level} {refit:?}");
        }
    }
}

#[test]
fn levels_end_where_locks_do_and_say_so() {
    let f = Folder::new();
    f.file("s.gltf", tiles(&FOUR[..2]));
    let part = r#"{"objects": ["*"], "lock-border": true}"#;
    for more in [&["--lock-border"][..], &["--part", part]] {
        for refit in [&["--no-refit"][..], &[]] {
            let args = ["extract", "s.gltf", "-o", "s.obj", "--ratio", "0.05"];
            let run = f.lodc(args.iter().chain(more).chain(refit)).ends(0);
            assert!(
                run.err.contains("2 of 2 objects") || run.err.contains("locked"),
                "{}",
                run.err
            );
            let kept = borders(&f.read("s.obj"));
            assert_eq!(kept.len(), 6 * TILE, "{more:?} {refit:?}");
        }
    }
    // The file says what is locked.
    f.lodc(["build", "s.gltf", "-o", "s.lodc", "--lock-border", "-q"]).ends(0);
    let run = f.lodc(["extract", "s.lodc", "-o", "s.obj", "--ratio", "0.05"]).ends(0);
    assert!(run.err.contains("locked"), "{}", run.err);
    assert_eq!(borders(&f.read("s.obj")).len(), 6 * TILE);
    f.lodc(["verify", "s.lodc", "--source", "s.gltf"]).ends(0);
    let args = ["extract", "s.lodc", "-o", "s.glb", "--per-object", "--lod"];
    let refused = f.lodc(args.iter().chain(&["9999"])).fails(2);
    assert!(refused.err.contains("locked"), "{}", refused.err);
    f.lodc(args.iter().chain(&["30"])).ends(0);
    f.lodc(["extract", "s.lodc", "-o", "s.glb", "--ratio", "0.5", "--lock-border"]).fails(2);
}

#[test]
fn borders_that_part_are_named_with_the_option() {
    let f = Folder::new();
    f.file("s.gltf", tiles(&FOUR));
    let extract = ["extract", "s.gltf", "-o", "s.glb", "--ratio"];
    let run = f.lodc(extract.iter().chain(&["0.3"])).ends(0);
    assert!(run.err.contains("--lock-border") && run.err.contains("tile11"), "{}", run.err);
    for quiet in [&["0.5", "--lock-border"][..], &["1"]] {
        let run = f.lodc(extract.iter().chain(quiet)).ends(0);
        assert!(!run.err.contains("--lock-border"), "{quiet:?}: {}", run.err);
    }
}

/// `n` cards, each of four vertices with the same rectangle of a texture.
fn cards(n: usize) -> (Vec<Vec<f32>>, Vec<Vec<f32>>, Vec<u32>) {
    let (mut points, mut uvs, mut corners) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..n {
        let angle = i as f32 * 2.4;
        let (s, c) = angle.sin_cos();
        let middle = [(i % 10) as f32 * 1.3, (i / 10) as f32 * 1.1, (i % 7) as f32 * 0.8];
        let size = 0.3 + 0.02 * (i % 5) as f32;
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            let (a, b) = ((u - 0.5) * size, (v - 0.5) * size);
            points.push(vec![middle[0] + a * c, middle[1] + a * s, middle[2] + b]);
            uvs.push(vec![u, v]);
        }
        let first = 4 * i as u32;
        corners.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
    }
    (points, uvs, corners)
}

/// The JSON chunk of a GLB and its binary one.
fn glb(f: &Folder, name: &str) -> (Value, Vec<u8>) {
    let bytes = f.read(name);
    let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let json = serde_json::from_slice(&bytes[20..20 + length]).expect("a JSON chunk");
    (json, bytes[28 + length..].to_vec())
}

/// The indices of an accessor.
fn indices((json, bytes): &(Value, Vec<u8>), accessor: &Value) -> Vec<u32> {
    let accessor = &json["accessors"][accessor.as_u64().expect("a number") as usize];
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize];
    let number = |of: &Value, key: &str| of[key].as_u64().unwrap_or(0) as usize;
    let first = number(view, "byteOffset") + number(accessor, "byteOffset");
    let size = match number(accessor, "componentType") {
        5121 => 1,
        5123 => 2,
        _ => 4,
    };
    let index = |k: usize| {
        let bytes = &bytes[first + k * size..][..size];
        bytes.iter().rev().fold(0, |n, &b| n << 8 | u32::from(b))
    };
    (0..number(accessor, "count")).map(index).collect()
}

#[test]
fn cards_go_whole_and_a_prefix_is_what_a_level_uses() {
    let f = Folder::new();
    let (points, uvs, corners) = cards(100);
    let mut scene = Scene::new();
    let attributes = [("POSITION", &points[..]), ("TEXCOORD_0", &uvs[..])];
    scene.add("leaves", &attributes, &corners, json!({}));
    f.file("leaves.gltf", scene.text());
    let args = ["chain", "leaves.gltf", "-o", "c.glb", "--levels", "100%,50%,25%,10%", "--json"];
    let report = f.lodc(args.iter().chain(&["--index-ranges", "-q"])).ends(0).json();
    let file = glb(&f, "c.glb");
    let primitive = &file.0["meshes"][0]["primitives"][0];
    let all = indices(&file, &primitive["indices"]);
    for (k, level) in
        primitive["extras"]["lodc"]["levels"].as_array().expect("levels").iter().enumerate()
    {
        let number = |key: &str| level[key].as_u64().expect("a number") as usize;
        let used: BTreeSet<u32> =
            all[number("first")..][..number("count")].iter().copied().collect();
        assert_eq!(number("vertices"), used.len(), "level {k}");
        assert_eq!(report["levels"][k]["vertices"].as_u64(), Some(used.len() as u64));
        // Cards are whole: four vertices for each two triangles, with at most one card by halves.
        assert!(used.len() * 6 <= 4 * number("count") + 6, "level {k}: {level}");
    }
}

#[test]
fn levels_of_a_hidden_node_are_hidden_and_their_channels_have_targets() {
    let f = Folder::new();
    let (points, corners) = tile(0, 0);
    let mut scene = Scene::new();
    let hidden = json!({"extensions": {"KHR_node_visibility": {"visible": false}}});
    scene.add("hidden", &[("POSITION", &points)], &corners, hidden);
    let times = scene.accessor(
        [0.0f32, 1.0].iter().flat_map(|t| t.to_le_bytes()).collect(),
        json!({"componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]}),
    );
    let shown =
        scene.accessor(vec![0, 1], json!({"componentType": 5121, "count": 2, "type": "SCALAR"}));
    let pointer = "/nodes/0/extensions/KHR_node_visibility/visible";
    scene.json["animations"] = json!([{
        "samplers": [{"input": times, "output": shown, "interpolation": "STEP"}],
        "channels": [{"sampler": 0, "target": {"path": "pointer",
            "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}}]}]);
    scene.json["extensionsUsed"] = json!(["KHR_node_visibility", "KHR_animation_pointer"]);
    f.file("s.gltf", scene.text());
    f.lodc(["chain", "s.gltf", "-o", "c.glb", "--levels", "100%,30%", "-q"]).ends(0);
    let (json, _) = glb(&f, "c.glb");
    let nodes = json["nodes"].as_array().expect("nodes");
    assert_eq!(nodes.len(), 2);
    for node in nodes {
        assert_eq!(node["extensions"]["KHR_node_visibility"]["visible"], false);
    }
    let channels = json["animations"][0]["channels"].as_array().expect("channels");
    let pointers: Vec<&str> = channels
        .iter()
        .map(|c| {
            let pointer = &c["target"]["extensions"]["KHR_animation_pointer"]["pointer"];
            pointer.as_str().expect("a pointer")
        })
        .collect();
    assert_eq!(pointers, [pointer, "/nodes/1/extensions/KHR_node_visibility/visible"]);
    f.lodc(["verify", "c.glb", "--source", "s.gltf"]).ends(0);
}

/// A bumpy sphere of `n` by `2 n` quadrilaterals as an OBJ, with a normal for each face, or none.
fn facetted(n: usize, with_normals: bool) -> String {
    let columns = 2 * n;
    let at = |row: usize, column: usize| {
        let polar = std::f64::consts::PI * row as f64 / n as f64;
        let around = std::f64::consts::TAU * (column % columns) as f64 / columns as f64;
        let p = [polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin()];
        let radius = 1.0 + 0.1 * ((5.0 * p[0]).sin() + (4.0 * p[1] + 3.0 * p[2]).cos());
        p.map(|c| c * radius)
    };
    let mut text = String::from("o ball\n");
    let number = |row: usize, column: usize| match row {
        0 => 1,
        row if row == n => 2 + (n - 1) * columns,
        row => 2 + (row - 1) * columns + column % columns,
    };
    for row in 0..=n {
        for column in 0..if row % n == 0 { 1 } else { columns } {
            let [x, y, z] = at(row, column);
            text += &format!("v {x:.6} {y:.6} {z:.6}\n");
        }
    }
    let mut faces = 0;
    for row in 0..n {
        for column in 0..columns {
            let quad = [(row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column)];
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                let corners = [a, b, c].map(|k| number(quad[k].0, quad[k].1));
                if corners[0] == corners[1] || corners[1] == corners[2] || corners[0] == corners[2]
                {
                    continue;
                }
                let [p, q, r] = [a, b, c].map(|k| at(quad[k].0, quad[k].1));
                let [u, v] = [q, r].map(|end| [0, 1, 2].map(|i| end[i] - p[i]));
                let n = [
                    u[1] * v[2] - u[2] * v[1],
                    u[2] * v[0] - u[0] * v[2],
                    u[0] * v[1] - u[1] * v[0],
                ];
                let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
                faces += 1;
                let [x, y, z] = corners;
                if with_normals {
                    let [nx, ny, nz] = n.map(|c| c / length);
                    text +=
                        &format!("vn {nx} {ny} {nz}\nf {x}//{faces} {y}//{faces} {z}//{faces}\n");
                } else {
                    text += &format!("f {x} {y} {z}\n");
                }
            }
        }
    }
    text
}

/// Faces of an OBJ whose corners have different normals.
fn mixed_faces(obj: &[u8]) -> usize {
    let text = String::from_utf8(obj.to_vec()).expect("text");
    let faces = text.lines().filter_map(|line| line.strip_prefix("f "));
    let is_mixed = |face: &&str| {
        let normals: BTreeSet<&str> =
            face.split_whitespace().filter_map(|c| c.rsplit('/').next()).collect();
        normals.len() > 1
    };
    faces.filter(is_mixed).count()
}

#[test]
fn the_shape_alone_costs_nothing_at_seams_and_flat_faces_stay_flat() {
    let f = Folder::new();
    f.file("flat.obj", facetted(12, true));
    f.file("bare.obj", facetted(12, false));
    let weights = ["--weight", "normal=0"];
    let built: [(&str, &str, &[&str]); 4] = [
        ("bare.obj", "bare.lodc", &[]),
        ("flat.obj", "alone.lodc", &["--no-attributes"]),
        ("flat.obj", "weightless.lodc", &weights),
        ("flat.obj", "flat.lodc", &[]),
    ];
    for (input, output, more) in built {
        f.lodc(["build", input, "-o", output, "-q"].iter().chain(more)).ends(0);
    }
    for ratio in ["0.5", "0.25", "0.1"] {
        let error = |input: &str| {
            let args = ["extract", input, "-o", "level.obj", "--ratio", ratio, "--json", "-q"];
            let level = |more: &[&str]| {
                let report = f.lodc(args.iter().chain(more)).ends(0).json();
                if input != "bare.lodc" {
                    assert_eq!(
                        mixed_faces(&f.read("level.obj")),
                        0,
                        "{input} at {ratio}, {more:?}"
                    );
                }
                report["error"].as_f64().expect("an error")
            };
            level(&[]);
            level(&["--no-refit"])
        };
        let bare = error("bare.lodc");
        for input in ["alone.lodc", "weightless.lodc"] {
            let own = error(input);
            assert!(own <= 1.1 * bare, "{input} at {ratio}: {own} for {bare}");
        }
        error("flat.lodc");
    }
}
