//! `lodc chain`: levels of one asset, over one vertex buffer or as a file each.

use crate::support::{Folder, grid};
use serde_json::Value;

fn chained(f: &Folder, input: &str, more: &[&str]) -> Value {
    let args = ["chain", input, "--json", "-q"];
    f.lodc(args.iter().chain(more)).ends(0).json()
}

/// The JSON chunk of a GLB.
fn document(f: &Folder, name: &str) -> Value {
    let bytes = f.read(name);
    let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).expect("a JSON chunk")
}

fn triangles(report: &Value) -> Vec<u64> {
    let levels = report["levels"].as_array().expect("levels").iter();
    levels.map(|l| l["triangles"].as_u64().expect("a count")).collect()
}

fn part(f: &Folder) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/machine_part.glb");
    f.file("part.glb", std::fs::read(path).expect("a fixture"));
}

#[test]
fn four_levels_share_one_vertex_buffer() {
    let f = Folder::new();
    part(&f);
    let report = chained(&f, "part.glb", &["-o", "chain.glb"]);
    assert_eq!(triangles(&report), [480, 240, 120, 48]);
    for (k, level) in report["levels"].as_array().expect("levels").iter().enumerate() {
        assert_eq!((&level["level"], &level["output"]), (&k.into(), &"chain.glb".into()));
        assert!(level["vertices"].as_u64() > Some(0) && level["distance"].is_null());
    }
    let json = document(&f, "chain.glb");
    let showing = |n: &&Value| n["extensions"]["MSFT_lod"].is_object();
    let nodes = json["nodes"].as_array().expect("nodes");
    let node = nodes.iter().find(showing).expect("a node with levels");
    let ids = node["extensions"]["MSFT_lod"]["ids"].as_array().expect("ids");
    let coverage = node["extras"]["MSFT_screencoverage"].as_array().expect("coverage");
    assert_eq!((ids.len(), coverage.len()), (3, 4));
    assert!(coverage.is_sorted_by(|a, b| a.as_f64() >= b.as_f64()), "{coverage:?}");
    // Every level refers to the same positions and has indices of its own.
    let mesh_of = |node: &Value| &json["meshes"][node["mesh"].as_u64().expect("a mesh") as usize];
    let finest = mesh_of(node)["primitives"].as_array().expect("primitives");
    for id in ids {
        let level = mesh_of(&json["nodes"][id.as_u64().expect("a node") as usize]);
        for primitive in level["primitives"].as_array().expect("primitives") {
            let same = finest.iter().find(|p| p["attributes"] == primitive["attributes"]);
            assert_ne!(same.expect("the same vertices")["indices"], primitive["indices"]);
        }
    }
    let bytes = report["outputs"][0]["bytes"].as_u64();
    assert_eq!(bytes, Some(f.read("chain.glb").len() as u64));
}

#[test]
fn a_chain_of_a_file_has_the_levels_of_extract() {
    let f = Folder::new();
    part(&f);
    f.lodc(["build", "part.glb", "-o", "part.lodc", "-q"]).ends(0);
    let levels = ["-o", "c.glb", "--levels", "100%,0.3,100,20"];
    let from_file = chained(&f, "part.lodc", &levels);
    let from_mesh = chained(&f, "part.glb", &levels);
    for (of_file, of_mesh) in (0..4).map(|k| (&from_file["levels"][k], &from_mesh["levels"][k])) {
        for key in ["lod", "triangles", "vertices", "gone"] {
            assert_eq!(of_file[key], of_mesh[key], "{key}");
        }
        let error = |level: &Value| level["error"].as_f64().expect("a number");
        // Bounds of levels by themselves are at most 2 % above the distances.
        assert!(error(of_mesh) <= 1.02 * error(of_file));
    }
    for (level, selector) in
        [(1, ["--ratio", "0.3"]), (2, ["--triangles", "100"]), (3, ["--triangles", "20"])]
    {
        let args = ["extract", "part.lodc", "-o", "e.glb", "--no-refit", "--json", "-q"];
        let one = f.lodc(args.iter().chain(&selector)).ends(0).json();
        for key in ["lod", "triangles", "error"] {
            assert_eq!(from_file["levels"][level][key], one[key], "{selector:?} {key}");
        }
    }
}

#[test]
fn separate_levels_are_files_of_their_own() {
    let f = Folder::new();
    part(&f);
    let report = chained(&f, "part.glb", &["-o", "out/p.glb", "--separate", "--levels", "50%,25%"]);
    let levels = report["levels"].as_array().expect("levels").iter();
    let paths: Vec<&str> = levels.map(|l| l["output"].as_str().expect("a path")).collect();
    assert_eq!(paths, ["out/p_LOD0.glb", "out/p_LOD1.glb"]);
    let shared = chained(&f, "part.glb", &["-o", "shared.glb", "--levels", "50%,25%"]);
    for (level, own) in report["levels"].as_array().expect("levels").iter().enumerate() {
        for key in ["lod", "error", "rms"] {
            assert_eq!(own[key], shared["levels"][level][key], "level {level}: {key}");
        }
    }
    let refitted = chained(
        &f,
        "part.glb",
        &["-o", "out/r.glb", "--separate", "--refit", "--levels", "50%,25%"],
    );
    assert_eq!(triangles(&report), triangles(&refitted));
    for name in ["out/p_LOD1.glb", "out/r_LOD1.glb"] {
        let info = f.lodc(["build", name, "-o", "again.lodc", "--report", "json", "-q"]).ends(0);
        assert_eq!(info.json()["inputs"][0]["triangles"].as_u64(), Some(triangles(&report)[1]));
    }
}

#[test]
fn index_ranges_lie_back_to_back() {
    let f = Folder::new();
    part(&f);
    let report = chained(&f, "part.glb", &["-o", "c.glb", "--index-ranges"]);
    let json = document(&f, "c.glb");
    let mut drawn = [0; 4];
    for primitive in json["meshes"][0]["primitives"].as_array().expect("primitives") {
        let ranges = primitive["extras"]["lodc"]["levels"].as_array().expect("ranges");
        let accessor = &json["accessors"][primitive["indices"].as_u64().expect("one") as usize];
        let mut next = 0;
        for (range, drawn) in ranges.iter().zip(&mut drawn) {
            assert_eq!(range["first"].as_u64(), Some(next));
            let count = range["count"].as_u64().expect("a count");
            next += count;
            *drawn += count / 3;
        }
        assert_eq!(accessor["count"].as_u64(), Some(next));
    }
    assert_eq!(drawn.to_vec(), triangles(&report));
}

#[test]
fn no_level_errs_more_than_the_cap() {
    let f = Folder::new();
    f.file("g.obj", grid(16));
    part(&f);
    f.lodc(["build", "part.glb", "-o", "part.lodc", "--models", "none", "-q"]).ends(0);
    let free = chained(&f, "part.lodc", &["-o", "c.glb"]);
    let cap = free["levels"][2]["error"].as_f64().expect("an error");
    let capped = chained(&f, "part.glb", &["-o", "c.glb", "--max-error", &cap.to_string()]);
    assert_eq!(triangles(&capped)[..3], triangles(&free)[..3]);
    assert!(capped["levels"][3]["error"].as_f64() <= Some(cap));
    let auto = chained(&f, "part.glb", &["-o", "c.glb", "--auto", "9", "--max-error", "1%"]);
    let counts = triangles(&auto);
    assert!(counts.is_sorted_by(|a, b| a > b) && counts.len() < 9, "{counts:?}");
}

#[test]
fn pixels_give_a_level_per_distance() {
    let f = Folder::new();
    part(&f);
    let report =
        chained(&f, "part.glb", &["-o", "c.glb", "--pixels", "1", "--distances", "10,100,1000"]);
    let levels = report["levels"].as_array().expect("levels");
    for (level, distance) in levels.iter().zip([10.0, 100.0, 1000.0]) {
        assert_eq!(level["distance"], distance);
        // A pixel of 1,080 at 60 degrees is that large there.
        let pixel = 2.0 * distance * 30f64.to_radians().tan() / 1080.0;
        assert!(level["error"].as_f64() <= Some(pixel), "{level}");
    }
    assert!(triangles(&report).is_sorted_by(|a, b| a >= b));
}

#[test]
fn wishes_that_make_no_sense_are_refused() {
    let f = Folder::new();
    part(&f);
    let refused = [
        (&["-o", "c.obj"][..], "--separate"),
        (&["-o", "c.xyz"], "extension"),
        (&["-o", "c.glb", "--levels", "25%,50%"], "finest first"),
        (&["-o", "c.glb", "--levels", "120%"], "100 %"),
        (&["-o", "c.glb", "--refit"], "--separate"),
        (&["-o", "c.glb", "--pixels", "1"], "--distances"),
        (&["-o", "c.glb", "--levels", "50%", "--auto", "3"], "cannot be used with"),
    ];
    for (args, word) in refused {
        let run = f.lodc(["chain", "part.glb"].iter().chain(args)).ends(2);
        assert!(run.err.contains(word), "{args:?}: {}", run.err);
    }
    f.lodc(["chain", "gone.glb", "-o", "c.glb"]).fails(3);
}

#[test]
fn a_level_that_shows_less_says_what_is_gone() {
    let f = Folder::new();
    let pane = "v 30 0 0\nv 36 0 0\nv 36 6 0\nv 30 6 0\nf -4 -3 -2 -1\n";
    f.file("w.obj", grid(12) + pane);
    let run = f.lodc(["chain", "w.obj", "-o", "w.glb", "--levels", "100%,1%", "--json"]).ends(0);
    let report = run.json();
    let levels = report["levels"].as_array().expect("levels");
    assert_eq!(levels[0]["gone"], serde_json::json!([]));
    let last = levels[1]["gone"].as_array().and_then(|gone| gone.last()).expect("something");
    assert_eq!(last["kind"], "surface");
    assert!(run.err.contains("level 1: ") && run.err.contains("is gone"), "{}", run.err);
}
