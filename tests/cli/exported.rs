//! `lodc verify LEVELS --source MESH`: what engines load is held to what it states.

use crate::support::{Folder, Run};
use serde_json::{Value, json};

/// A folder with a fixture and its chain as a glTF and a file of numbers beside it.
fn chained(fixture: &str, more: &[&str]) -> Folder {
    let f = Folder::new();
    let path = format!("{}/../fixtures/{fixture}", env!("CARGO_MANIFEST_DIR"));
    f.file(fixture, std::fs::read(path).expect("a fixture"));
    let args = ["chain", fixture, "-o", "c.gltf", "-q"];
    f.lodc(args.iter().chain(more)).ends(0);
    f
}

fn verify(f: &Folder, levels: &str, source: &str) -> Run {
    f.lodc(["verify", levels, "--source", source])
}

/// The checks that found a difference.
fn found(run: &Run) -> Vec<String> {
    let text = run.text();
    let different = text.lines().filter(|line| line.contains("DIFFERENT"));
    different.map(|line| line.split(", ").nth(1).unwrap_or_default().to_owned()).collect()
}

/// Writes the chain anew with another document, or other numbers.
fn injected(f: &Folder, change: impl FnOnce(&mut Value, &mut Vec<u8>)) {
    let mut document: Value = serde_json::from_slice(&f.read("c.gltf")).expect("a document");
    let mut numbers = f.read("c.bin");
    change(&mut document, &mut numbers);
    document["buffers"][0]["uri"] = "d.bin".into();
    f.file("d.gltf", document.to_string());
    f.file("d.bin", numbers);
}

/// Where in the numbers element `i` of an accessor begins.
fn place(document: &Value, accessor: &Value, i: usize) -> usize {
    let accessor = &document["accessors"][number(accessor)];
    let view = &document["bufferViews"][number(&accessor["bufferView"])];
    let components = match accessor["type"].as_str() {
        Some("SCALAR") => 1,
        Some("VEC2") => 2,
        Some("VEC3") => 3,
        _ => 4,
    };
    let size = match accessor["componentType"].as_u64() {
        Some(5120 | 5121) => 1,
        Some(5122 | 5123) => 2,
        _ => 4,
    };
    let stride = view["byteStride"].as_u64().map_or(components * size, |s| s as usize);
    number(&view["byteOffset"]) + number(&accessor["byteOffset"]) + i * stride
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap_or(0) as usize
}

fn node_of_levels(document: &Value) -> usize {
    let nodes = document["nodes"].as_array().expect("nodes");
    nodes.iter().position(|n| n["extensions"]["MSFT_lod"].is_object()).expect("a chain")
}

fn double(numbers: &mut [u8], at: usize) {
    let float = &mut numbers[at..at + 4];
    let value = f32::from_le_bytes(float.try_into().expect("four bytes"));
    float.copy_from_slice(&(2.0 * value + 1.0).to_le_bytes());
}

#[test]
fn what_extract_and_chain_write_is_right() {
    for fixture in
        ["machine_part.glb", "machine_part.obj", "skinned_tube_u8.glb", "morphing_sphere.glb"]
    {
        let f = chained(fixture, &[]);
        f.lodc(["chain", fixture, "-o", "ranges.glb", "--index-ranges", "-q"]).ends(0);
        f.lodc(["chain", fixture, "-o", "own.glb", "--separate", "-q", "--refit"]).ends(0);
        let coded = ["--compress", "meshopt", "--quantize", "pos=11,normal=8,uv=10"];
        let args = ["chain", fixture, "-o", "coded.glb", "-q"];
        f.lodc(args.iter().chain(&coded)).ends(0);
        f.lodc(["extract", fixture, "--ratio", "20%", "-o", "one.glb", "-q"]).ends(0);
        f.lodc(["extract", fixture, "--ratio", "20%", "-o", "one.obj", "-q"]).ends(0);
        let files = [
            "c.gltf",
            "ranges.glb",
            "own_LOD0.glb",
            "own_LOD2.glb",
            "coded.glb",
            "one.glb",
            "one.obj",
        ];
        for levels in files {
            let text = verify(&f, levels, fixture).ends(0).text();
            assert!(text.contains("levels, errors hold, cpu: ok"), "{fixture}, {levels}: {text}");
        }
    }
}

#[test]
fn levels_are_found_in_folders_and_their_meshes_by_content() {
    let f = chained("machine_part.glb", &["--json"]);
    std::fs::create_dir(f.join("out")).expect("a folder");
    f.lodc(["chain", "machine_part.glb", "-o", "out/part.glb", "-q"]).ends(0);
    f.lodc(["build", "machine_part.glb", "-o", "out/part.lodc", "-q"]).ends(0);
    f.file(
        "out/cube.glb",
        std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/coloured_cube.glb"))
            .expect("a fixture"),
    );
    std::fs::create_dir(f.join("models")).expect("a folder");
    f.file("models/renamed.glb", f.read("machine_part.glb"));
    let args = ["verify", "out", "--source", "models", "--json", "--junit", "r.xml"];
    let report = f.lodc(args).ends(0).json();
    let names: Vec<_> =
        report["files"].as_array().expect("files").iter().map(|f| f["file"].clone()).collect();
    assert_eq!(names.len(), 2, "a mesh that is no level is someone else's: {names:?}");
    let checks = report["files"][0]["checks"].as_array().expect("checks");
    assert!(checks.iter().any(|c| c["model"] == "levels" && c["lods"] == 4 && c["ok"] == true));
    let suites = String::from_utf8(f.read("r.xml")).expect("text");
    assert!(suites.contains("levels, levels share vertices"), "{suites}");

    let run = f.lodc(["verify", "out/part.glb"]).ends(2);
    assert!(run.err.contains("give it with --source MESH"), "{}", run.err);
    let run = f.lodc(["verify", "out/cube.glb", "--source", "machine_part.glb"]);
    assert!(run.ends(3).err.contains("not written by `lodc extract`"), "a mesh");
}

type Inject = fn(&mut Value, &mut Vec<u8>);

/// Each was made by hand: a defect, and the check that has to see it.
const DEFECTS: &[(&str, &str, Inject)] = &[
    ("an error of half the size", "errors hold", |d, _| {
        let error = &mut d["extras"]["lodc"]["levels"][2]["error"];
        *error = (error.as_f64().expect("an error") * 0.5).into();
    }),
    ("an error of twice the size", "errors hold", |d, _| {
        let error = &mut d["extras"]["lodc"]["levels"][3]["error"];
        *error = (error.as_f64().expect("an error") * 2.0).into();
    }),
    ("another mesh", "levels are of this mesh", |d, _| {
        d["extras"]["lodc"]["source"] = "0123456789abcdef0123456789abcdef".into();
    }),
    ("a vertex that moved", "vertices are the input's", |d, numbers| {
        let at = place(d, &d["meshes"][0]["primitives"][0]["attributes"]["POSITION"], 0);
        double(numbers, at);
    }),
    ("a normal that turned", "vertices are the input's", |d, numbers| {
        let at = place(d, &d["meshes"][0]["primitives"][0]["attributes"]["NORMAL"], 3);
        double(numbers, at);
    }),
    ("levels in another order", "errors hold", |d, _| {
        let node = node_of_levels(d);
        let ids = d["nodes"][node]["extensions"]["MSFT_lod"]["ids"].as_array_mut();
        ids.expect("ids").swap(0, 2);
    }),
    ("a triangle that is gone", "errors hold", |d, numbers| {
        let node = node_of_levels(d);
        let ids = &d["nodes"][node]["extensions"]["MSFT_lod"]["ids"];
        let mesh = number(&d["nodes"][number(&ids[0])]["mesh"]);
        let indices = &d["meshes"][mesh]["primitives"][0]["indices"];
        let (first, second) = (place(d, indices, 0), place(d, indices, 1));
        let bytes = numbers[first..second].to_vec();
        numbers[second..second + bytes.len()].copy_from_slice(&bytes);
    }),
    ("a triangle that is turned over", "triangles face as the input's", |d, numbers| {
        let node = node_of_levels(d);
        let ids = &d["nodes"][node]["extensions"]["MSFT_lod"]["ids"];
        let mesh = number(&d["nodes"][number(&ids[1])]["mesh"]);
        let indices = &d["meshes"][mesh]["primitives"][0]["indices"];
        let (first, second, third) =
            (place(d, indices, 6), place(d, indices, 7), place(d, indices, 8));
        for i in 0..third - second {
            numbers.swap(first + i, second + i);
        }
    }),
    ("a node that moved", "errors hold", |d, _| {
        let node = node_of_levels(d);
        d["nodes"][node]["translation"] = json!([0.5, 0.0, 0.0]);
        for id in d["nodes"][node]["extensions"]["MSFT_lod"]["ids"].clone().as_array().expect("ids")
        {
            d["nodes"][number(id)]["translation"] = json!([0.5, 0.0, 0.0]);
        }
    }),
    ("a colour", "nothing else changed", |d, _| {
        d["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.1, 0.2, 0.3, 1.0]);
    }),
    ("a material's name", "nothing else changed", |d, _| {
        d["materials"][0]["name"] = "other".into();
    }),
    ("a node's name", "nothing else changed", |d, _| d["nodes"][0]["name"] = "other".into()),
    ("a mesh's name", "nothing else changed", |d, _| d["meshes"][0]["name"] = "other".into()),
    ("a primitive's material", "nothing else changed", |d, _| {
        let count = d["meshes"].as_array().expect("meshes").len();
        for mesh in 0..count {
            d["meshes"][mesh]["primitives"][0].as_object_mut().expect("one").remove("material");
        }
    }),
    ("extras that are new", "nothing else changed", |d, _| {
        d["nodes"][0]["extras"]["note"] = "new".into();
    }),
    ("a scene's nodes", "nothing else changed", |d, _| d["scenes"][0]["nodes"] = json!([])),
    ("a copyright", "nothing else changed", |d, _| {
        d["asset"]["copyright"] = "someone".into();
    }),
    ("a level at another place", "levels share vertices", |d, _| {
        let node = node_of_levels(d);
        let id = number(&d["nodes"][node]["extensions"]["MSFT_lod"]["ids"][1]);
        d["nodes"][id]["translation"] = json!([0.0, 0.0, 9.0]);
    }),
    ("shares of the screen that rise", "levels share vertices", |d, _| {
        let node = node_of_levels(d);
        let shares = d["nodes"][node]["extras"]["MSFT_screencoverage"].as_array_mut();
        shares.expect("shares").reverse();
    }),
    ("a share of the screen too few", "levels share vertices", |d, _| {
        let node = node_of_levels(d);
        let shares = d["nodes"][node]["extras"]["MSFT_screencoverage"].as_array_mut();
        shares.expect("shares").pop();
    }),
    ("a level with vertices of its own", "levels share vertices", |d, _| {
        let node = node_of_levels(d);
        let id = number(&d["nodes"][node]["extensions"]["MSFT_lod"]["ids"][0]);
        let mesh = number(&d["nodes"][id]["mesh"]);
        let normals = d["meshes"][mesh]["primitives"][0]["attributes"]["NORMAL"].clone();
        d["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"] = normals;
    }),
];

#[test]
fn injected_defects_are_found() {
    let f = chained("machine_part.glb", &[]);
    assert_eq!(found(&verify(&f, "c.gltf", "machine_part.glb").ends(0)), [""; 0]);
    injected(&f, |_, _| {});
    assert_eq!(
        found(&verify(&f, "d.gltf", "machine_part.glb").ends(0)),
        [""; 0],
        "nothing injected"
    );
    for (name, check, inject) in DEFECTS {
        injected(&f, inject);
        let run = verify(&f, "d.gltf", "machine_part.glb").ends(1);
        assert!(found(&run).iter().any(|c| c == check), "{name}: {}", run.text());
    }
}

#[test]
fn injected_ranges_are_found() {
    let f = chained("skinned_tube_u8.glb", &["--index-ranges"]);
    let levels = |d: &mut Value, level: usize, key: &str, by: i64| {
        let entry = &mut d["meshes"][0]["primitives"][0]["extras"]["lodc"]["levels"][level][key];
        *entry = (entry.as_i64().expect("a range") + by).into();
    };
    for (level, key, by) in
        [(1, "first", 3), (1, "first", -3), (3, "count", -3), (2, "vertices", 1)]
    {
        injected(&f, |d, _| levels(d, level, key, by));
        let run = verify(&f, "d.gltf", "skinned_tube_u8.glb").ends(1);
        assert!(found(&run).iter().any(|c| c == "levels share vertices"), "{key}: {}", run.text());
    }
}

/// The sphere bends far more at weight 1 than at rest.
#[test]
fn errors_are_measured_in_the_poses_that_they_are_over() {
    let f = chained("morphing_sphere.glb", &[]);
    let over = |d: &Value| d["extras"]["lodc"]["errors_over"].clone();
    injected(&f, |d, _| {
        assert_eq!(over(d), json!({ "rest": true, "poses": 2 }));
        let poses = d["extras"]["lodc"]["poses"][0].as_array().expect("poses of the object");
        assert!(poses.len() == 2 && poses.contains(&json!({ "target": 1 })), "{poses:?}");
    });
    let scaled = |d: &mut Value, by: f64| {
        let error = &mut d["extras"]["lodc"]["levels"][1]["error"];
        *error = (error.as_f64().expect("an error") * by).into();
    };
    let errors_hold = |run: Run| !found(&run).iter().any(|check| check == "errors hold");
    for (by, with_poses, holds) in
        [(1.0, true, true), (0.7, true, false), (2.0, true, false), (0.7, false, true)]
    {
        injected(&f, |d, _| {
            scaled(d, by);
            if !with_poses {
                let lodc = d["extras"]["lodc"].as_object_mut().expect("facts");
                lodc.remove("errors_over");
                lodc.remove("poses");
            }
        });
        let run = verify(&f, "d.gltf", "morphing_sphere.glb");
        assert_eq!(errors_hold(run), holds, "{by} times, poses: {with_poses}");
    }
}

/// glTF has two numbers for each texture coordinate, OBJ one to three.
#[test]
fn texture_coordinates_of_one_or_three_numbers_become_two() {
    for uv in ["0.5", "0.5 0.25", "0.5 0.25 0.75"] {
        let f = Folder::new();
        let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\n";
        let faces = "f 1/1 2/1 3/1\nf 1/1 3/1 4/1\n";
        f.file("m.obj", format!("{corners}vt {uv}\n{faces}"));
        f.lodc(["chain", "m.obj", "-o", "c.glb", "--index-ranges", "-q"]).ends(0);
        verify(&f, "c.glb", "m.obj").ends(0);
        f.lodc(["extract", "c.glb", "--lod", "0", "-o", "again.obj", "-q"]).ends(0);
        let text = String::from_utf8(f.read("again.obj")).expect("text");
        let expected = if uv == "0.5" { "vt 0.5 0" } else { "vt 0.5 0.25" };
        assert!(text.contains(expected), "{uv}: {text}");
    }
}
