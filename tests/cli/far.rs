//! Files far from the origin: coordinates in doubles go in and out as they are.

use crate::support::{Folder, base64};
use serde_json::{Value, json};

/// A bumpy patch of `n` by `n` squares, `size` across, about a place, with three decimals.
fn patch(n: usize, size: f64, at: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let mut points = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let [u, v] = [i, j].map(|k| k as f64 / n as f64 - 0.5);
            let height = 0.1 * ((7.0 * u).sin() * (5.0 * v).cos() + 0.2 * (23.0 * u * v).sin());
            let p = [u, v, height].map(|c| c * size);
            points.push([0, 1, 2].map(|k| ((p[k] + at[k]) * 1000.0).round() / 1000.0));
        }
    }
    let mut faces = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            faces.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
    }
    (points, faces)
}

const FAR: [f64; 3] = [4_649_776.123, -512_345.678, 4_217_590.25];

fn obj(points: &[[f64; 3]], faces: &[[usize; 3]]) -> String {
    let mut text = String::from("o site\n");
    for [x, y, z] in points {
        text += &format!("v {x:.3} {y:.3} {z:.3}\n");
    }
    for [a, b, c] in faces {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    text
}

fn ply(points: &[[f64; 3]], faces: &[[usize; 3]]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\n\
         property double y\nproperty double z\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        points.len(),
        faces.len()
    )
    .into_bytes();
    bytes.extend(points.iter().flatten().flat_map(|c| c.to_le_bytes()));
    for face in faces {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|&v| (v as u32).to_le_bytes()));
    }
    bytes
}

/// The same as text whose header says single precision.
fn text_ply(points: &[[f64; 3]], faces: &[[usize; 3]]) -> String {
    let mut text = format!(
        "ply\r\nformat ascii 1.0\r\nelement vertex {}\r\nproperty float x\r\n\
         property float32 y\r\nproperty   float z\r\nelement face {}\r\n\
         property list uchar int vertex_indices\r\nend_header\r\n",
        points.len(),
        faces.len()
    );
    points.iter().for_each(|p| text += &(spelt(p) + "\r\n"));
    faces.iter().for_each(|[a, b, c]| text += &format!("3 {a} {b} {c}\r\n"));
    text
}

/// The positions of an OBJ as text, sorted.
fn positions(obj: &[u8]) -> Vec<String> {
    let text = String::from_utf8(obj.to_vec()).expect("text");
    let mut lines: Vec<String> =
        text.lines().filter_map(|line| line.strip_prefix("v ")).map(str::to_owned).collect();
    lines.sort();
    lines
}

/// As an OBJ writes it, without zeros at the end.
fn spelt(p: &[f64; 3]) -> String {
    p.map(|c| c.to_string()).join(" ")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// The root mean square and the largest distance of a level, as `compare` has them.
fn compared(f: &Folder, a: &str, b: &str) -> [f64; 2] {
    let found = f.lodc(["compare", a, b, "--json", "--views", "0"]).ends(0).json();
    [number(&found["rms"]["max"]), number(&found["hausdorff"]["max"])]
}

#[test]
fn an_obj_far_away_keeps_its_doubles_and_its_digits() {
    let f = Folder::new();
    let (points, faces) = patch(12, 3.7, FAR);
    f.file("site.obj", obj(&points, &faces));
    f.file("site.ply", ply(&points, &faces));
    f.file("text.ply", text_ply(&points, &faces));
    let mut expected: Vec<String> = points.iter().map(spelt).collect();
    expected.sort();
    let inputs = [("site.obj", "site.lodc"), ("site.ply", "ply.lodc"), ("text.ply", "text.lodc")];
    for (input, more) in inputs {
        f.lodc(["build", input, "-o", more, "-q"]).ends(0);
        for from in [input, more] {
            let args = ["extract", from, "--ratio", "1", "-q", "-o"];
            f.lodc(args.iter().chain(&["full.obj"])).ends(0);
            assert_eq!(positions(&f.read("full.obj")), expected, "{from}");
            f.lodc(args.iter().chain(&["full.ply"])).ends(0);
            assert!(f.read("full.ply").windows(17).any(|w| w == b"property double x"));
            f.lodc(["extract", "full.ply", "--ratio", "1", "-q", "-o", "again.obj"]).ends(0);
            assert_eq!(positions(&f.read("again.obj")), expected, "{from} by PLY");
            f.lodc(args.iter().chain(&["full.glb"])).ends(0);
            f.lodc(["extract", "full.glb", "--ratio", "1", "-q", "-o", "again.obj"]).ends(0);
            assert_eq!(positions(&f.read("again.obj")), expected, "{from} by GLB");
        }
        for output in ["half.obj", "half.ply", "half.glb"] {
            for how in [&["--no-refit"][..], &[]] {
                let args = ["extract", input, "--ratio", "0.4", "-o", output, "--json"];
                let level = f.lodc(args.iter().chain(how)).ends(0).json();
                let [rms, hausdorff] = compared(&f, input, output);
                let (error, stated_rms) = (number(&level["error"]), number(&level["rms"]));
                let what = format!("{input} as {output}, {how:?}: {error} for {hausdorff}");
                assert!(hausdorff <= 1.05 * error && error <= 1.6 * hausdorff, "{what}");
                assert!(rms <= 1.2 * stated_rms && stated_rms <= 1.4 * rms, "{what}: rms {rms}");
                f.lodc(["verify", output, "--source", input]).ends(0);
            }
        }
    }
    // A stream keeps the offset, too.
    f.lodc(["pack", "site.lodc", "-o", "site.lods", "-q"]).ends(0);
    f.lodc(["unpack", "site.lods", "-o", "back.obj", "-q"]).ends(0);
    assert_eq!(positions(&f.read("back.obj")), expected);
}

/// A glTF of one mesh about the origin, shown by a node for each translation.
fn gltf(points: &[[f64; 3]], faces: &[[usize; 3]], at: &[[f64; 3]]) -> String {
    let mut bytes: Vec<u8> =
        points.iter().flatten().flat_map(|&c| (c as f32).to_le_bytes()).collect();
    let positions = bytes.len();
    bytes.extend(faces.iter().flatten().flat_map(|&v| (v as u32).to_le_bytes()));
    let bound = |pick: fn(f32, f32) -> f32| {
        [0, 1, 2].map(|k| points.iter().map(|p| p[k] as f32).reduce(pick).expect("a point"))
    };
    let nodes: Vec<Value> = at.iter().map(|at| json!({"mesh": 0, "translation": at})).collect();
    let uri = format!("data:application/octet-stream;base64,{}", base64(&bytes));
    json!({
        "asset": {"version": "2.0"}, "scene": 0,
        "scenes": [{"nodes": (0..at.len()).collect::<Vec<_>>()}], "nodes": nodes,
        "meshes": [{"name": "site",
            "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": points.len(), "type": "VEC3",
             "min": bound(f32::min), "max": bound(f32::max)},
            {"bufferView": 1, "componentType": 5125, "count": 3 * faces.len(), "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": positions},
            {"buffer": 0, "byteOffset": positions, "byteLength": bytes.len() - positions}],
        "buffers": [{"byteLength": bytes.len(), "uri": uri}]})
    .to_string()
}

#[test]
fn a_node_far_away_keeps_its_numbers_and_is_measured_in_doubles() {
    let f = Folder::new();
    let (points, faces) = patch(12, 3.7, [0.0; 3]);
    f.file("site.gltf", gltf(&points, &faces, &[FAR]));
    let args = ["extract", "site.gltf", "--ratio", "0.3", "-o"];
    for how in [&["q.glb", "--quantize", "pos=14"][..], &["p.glb"]] {
        let level = f.lodc(args.iter().chain(how).chain(&["--json"])).ends(0).json();
        let bytes = f.read(how[0]);
        let json = String::from_utf8_lossy(&bytes);
        for c in FAR {
            assert!(json.contains(&c.to_string()), "{how:?}: {c}");
        }
        f.lodc(["verify", how[0], "--source", "site.gltf"]).ends(0);
        let [rms, hausdorff] = compared(&f, "site.gltf", how[0]);
        assert!(hausdorff <= 1.05 * number(&level["error"]), "{how:?}: {hausdorff}");
        assert!(rms <= 1.2 * number(&level["rms"]), "{how:?}: {rms}");
        assert!(rms >= number(&level["rms"]) / 1.4, "{how:?}: {rms}");
    }
    f.lodc(["extract", "site.gltf", "--ratio", "1", "-o", "full.obj", "-q"]).ends(0);
    assert_eq!(positions(&f.read("full.obj")).len(), points.len(), "no two became one");
    let [_, hausdorff] = compared(&f, "site.gltf", "full.obj");
    assert!(hausdorff < 1e-6, "{hausdorff}");
    // Views are about the target in doubles: detail stays where it is looked at.
    let [x, y, z] = FAR;
    let target = format!("{x},{y},{z}");
    let view = ["extract", "site.gltf", "-o", "v.glb", "--criterion", "sphere", "--radius", "0.5"];
    let seen = f.lodc(view.iter().chain(&["--target", &target, "--json"])).ends(0).json();
    let away = format!("{},{y},{z}", x + 10.0);
    let unseen = f.lodc(view.iter().chain(&["--target", &away, "--json"])).ends(0).json();
    assert!(number(&seen["triangles"]) > 2.0 * number(&unseen["triangles"]), "{seen} {unseen}");
}

#[test]
fn two_objects_a_thousand_kilometres_apart_work() {
    let f = Folder::new();
    let (points, faces) = patch(10, 5.0, [0.0; 3]);
    f.file("two.gltf", gltf(&points, &faces, &[[0.0; 3], [1e6, 0.0, 0.0]]));
    f.lodc(["build", "two.gltf", "-o", "two.lodc", "-q"]).ends(0);
    f.lodc(["verify", "two.lodc", "--source", "two.gltf"]).ends(0);
    f.lodc(["extract", "two.lodc", "--ratio", "0.5", "-o", "half.glb", "-q"]).ends(0);
    f.lodc(["verify", "half.glb", "--source", "two.gltf"]).ends(0);
}

/// The largest distance of the vertices of an OBJ from the plane that a flat input lies in, and
/// from the nearest vertex of the input.
fn off(f: &Folder, output: &str, points: &[[f64; 3]]) -> [f64; 2] {
    let read = |line: &String| {
        let mut numbers = line.split(' ').map(|c| c.parse::<f64>().expect("a coordinate"));
        [(); 3].map(|()| numbers.next().expect("three coordinates"))
    };
    let distance = |a: &[f64; 3], b: &[f64; 3]| {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    let of_vertex = |p: [f64; 3]| {
        let nearest = points.iter().map(|q| distance(&p, q)).fold(f64::INFINITY, f64::min);
        [(p[2] - points[0][2]).abs(), nearest]
    };
    let vertices = positions(&f.read(output));
    let all = vertices.iter().map(read).map(of_vertex);
    all.reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]).expect("a vertex")
}

#[test]
fn errors_contain_what_rounding_leaves() {
    let f = Folder::new();
    for (far, size) in [(1.0, 1e-3), (0.01, 1.0), (1.0, 1.0), (1.0, 300.0), (200.0, 1e-3)] {
        let at = FAR.map(|c| c * far + 0.1 / 3.0);
        // What doubles round does not count.
        let double = 5e6 * far * f64::EPSILON;
        // Flat, with all the digits that a double has.
        let (mut points, faces) = patch(10, 1.0, [0.0; 3]);
        for p in &mut points {
            *p = [p[0] * size + at[0], p[1] * size / 3.0 + at[1], at[2]];
        }
        f.file("flat.ply", ply(&points, &faces));
        let text: String = points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        let corners = obj(&[], &faces);
        f.file("flat.obj", text + corners.strip_prefix("o site\n").expect("a name"));
        for input in ["flat.obj", "flat.ply"] {
            for ratio in ["1", "0.4", "0.1"] {
                let args = ["extract", input, "--ratio", ratio, "--json", "-o", "level.obj"];
                let error = number(&f.lodc(args).ends(0).json()["error"]);
                let [from_plane, from_vertex] = off(&f, "level.obj", &points);
                let what = format!("{input} {far} {size} {ratio}: {error}");
                assert!(from_plane <= error + double, "{what} for {from_plane}");
                if ratio == "1" {
                    assert!(from_vertex <= error + double, "{what} for {from_vertex}");
                    assert!(from_vertex <= 1e-7 * size + double, "{what} for {from_vertex}");
                }
                assert!(error <= 1e-6 * size, "{what}");
                f.lodc(["verify", "level.obj", "--source", input]).ends(0);
            }
        }
        // In single precision about a node that is far.
        let (mut local, _) = patch(10, 1.0, [0.0; 3]);
        for p in &mut local {
            *p = [p[0] * size, p[1] * size / 3.0, 0.0].map(|c| f64::from(c as f32));
        }
        f.file("flat.gltf", gltf(&local, &faces, &[at]));
        let placed: Vec<[f64; 3]> =
            local.iter().map(|p| std::array::from_fn(|k| p[k] + at[k])).collect();
        for ratio in ["1", "0.4"] {
            let args = ["extract", "flat.gltf", "--ratio", ratio, "--json", "-o", "level.obj"];
            let error = number(&f.lodc(args).ends(0).json()["error"]);
            let [from_plane, from_vertex] = off(&f, "level.obj", &placed);
            let what = format!("{far} {size} {ratio}: {error} for {from_plane}, {from_vertex}");
            assert!(from_plane <= error + double && error <= 1e-6 * size, "{what}");
            assert!(ratio != "1" || from_vertex <= error + 2.0 * double, "{what}");
            f.lodc(["verify", "level.obj", "--source", "flat.gltf"]).ends(0);
        }
    }
}
