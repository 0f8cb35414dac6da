//! `lodc extract` of meshes and of several inputs.

use crate::support::{Folder, grid};
use serde_json::Value;

fn part(f: &Folder) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/machine_part.glb");
    f.file("part.glb", std::fs::read(path).expect("a fixture"));
}

#[test]
fn a_mesh_gives_the_level_that_its_lodc_file_gives() {
    let f = Folder::new();
    part(&f);
    let same = |selector: [&str; 2], metric: [&str; 2]| {
        let of_mesh = ["extract", "part.glb", "-o", "a.glb", "-q"];
        f.lodc(of_mesh.iter().chain(&selector).chain(&metric)).ends(0);
        f.lodc(["extract", "part.lodc", "-o", "b.glb", "-q"].iter().chain(&selector)).ends(0);
        assert!(f.read_binary("a.glb") == f.read_binary("b.glb"), "{selector:?}");
    };
    for metric in [["--metric", "hybrid"], ["--metric", "quadric"]] {
        f.lodc(["build", "part.glb", "-o", "part.lodc", "-q"].iter().chain(&metric)).ends(0);
        same(["--ratio", "25%"], metric);
        same(["--triangles", "0.1k"], metric);
        same(["--error", "1%"], metric);
    }
    let run = f.lodc(["extract", "part.glb", "-o", "c.glb", "--ratio", "0.5", "--model", "speed"]);
    assert!(run.fails(2).err.contains("it has: reference"));
}

#[test]
fn a_cap_holds_whatever_is_wanted() {
    let f = Folder::new();
    part(&f);
    let extract = |more: &[&str]| -> Value {
        let args = ["extract", "part.glb", "-o", "o.glb", "--json", "-q"];
        f.lodc(args.iter().chain(more)).ends(0).json()
    };
    let alone = extract(&["--error", "0.5%"]);
    let capped = extract(&["--ratio", "1%", "--max-error", "0.5%"]);
    assert_eq!(alone["lod"], capped["lod"]);
    let loose = extract(&["--ratio", "50%", "--max-error", "50%"]);
    assert_eq!(loose["lod"], extract(&["--ratio", "50%"])["lod"]);
    // One pixel of 1,080 at a distance of 540 / tan 30° is one unit.
    let distance = (540.0 / 30f64.to_radians().tan()).to_string();
    let seen = extract(&["--pixels", "0.01", "--distance", &distance]);
    assert_eq!(seen["lod"], extract(&["--error", "0.01"])["lod"]);
}

#[test]
fn selectors_say_which_of_them_was_meant() {
    let f = Folder::new();
    part(&f);
    let fails = |more: &[&str]| -> String {
        f.lodc(["extract", "part.glb", "-o", "o.glb"].iter().chain(more)).ends(2).err
    };
    assert!(fails(&["--ratio", "10k"]).contains("--triangles"));
    assert!(fails(&["--triangles", "25%"]).contains("--ratio"));
    assert!(fails(&["--pixels", "1"]).contains("--distance"));
    assert!(fails(&["--ratio", "0.5", "--triangles", "5"]).contains("cannot be used with"));
    assert!(fails(&[]).contains("required"));
}

#[test]
fn several_inputs_have_a_result_each_whatever_becomes_of_the_others() {
    let f = Folder::new();
    f.file("a.obj", grid(6));
    f.file("b/c.obj", grid(6));
    f.file("c.obj", grid(8));
    f.file("bad.obj", "v 0 0\nf 1 2 3\n");
    let inputs = ["a.obj", "c.obj", "b/c.obj", "bad.obj"];
    let args = ["-o", "out/deep", "--ratio", "50%", "--json", "--depfile", "d"];
    let run = f.lodc(["extract"].iter().chain(&inputs).chain(&args)).ends(3);
    assert_eq!(run.errors(), 3, "{}", run.err);
    let report = run.json();
    let results = report["results"].as_array().expect("results");
    let status = |r: &Value| r["status"].as_u64().expect("a status");
    assert_eq!(results.iter().map(status).collect::<Vec<_>>(), [0, 2, 2, 3]);
    assert_eq!(report["status"], 3);
    for (result, input) in results.iter().zip(inputs) {
        assert_eq!(result["input"], input);
        assert!(status(result) == 0 || result["error"].is_string(), "{result}");
    }
    assert!(results[1]["error"].as_str().is_some_and(|e| e.contains("b/c.obj")), "{report}");
    assert!(f.has("out/deep/a.obj.glb") && !f.has("out/deep/c.obj.glb"));
    let rules = String::from_utf8(f.read("d")).expect("text");
    assert!(rules.starts_with("out/deep/a.obj.glb:") && !rules.contains("c.obj.glb"), "{rules}");
}

#[test]
fn a_failure_is_a_document_too() {
    let f = Folder::new();
    f.file("a.obj", grid(4));
    let failed = |args: &[&str], status: i32| {
        let json = f.lodc(args).fails(status).json();
        assert_eq!((&json["schema_version"], &json["status"]), (&1.into(), &status.into()));
        assert!(json["error"].as_str().is_some_and(|e| !e.is_empty()), "{json}");
    };
    failed(&["extract", "none.obj", "-o", "o.glb", "--ratio", "1", "--json"], 3);
    failed(&["extract", "a.obj", "-o", "o.xyz", "--ratio", "1", "--json"], 2);
    failed(&["extract", "a.obj", "-o", "no/o.glb", "--ratio", "1", "--json"], 4);
    failed(&["compare", "a.obj", "none.obj", "--json"], 3);
    failed(&["chain", "none.obj", "-o", "o.glb", "--json"], 3);
}

#[test]
fn builds_that_would_share_an_output_fail_alone() {
    let f = Folder::new();
    f.file("a.obj", grid(4));
    f.file("b/a.obj", grid(5));
    f.file("c.obj", grid(4));
    let args = ["build", "a.obj", "b/a.obj", "c.obj", "-o", "out/", "--report", "json", "-q"];
    let report = f.lodc(args).ends(2).json();
    let status: Vec<_> = (0..3).map(|i| report["inputs"][i]["status"].clone()).collect();
    assert_eq!(status, [2, 2, 0]);
    assert!(f.has("out/c.obj.lodc") && !f.has("out/a.obj.lodc"));
}

#[test]
fn compare_reads_levels() {
    let f = Folder::new();
    part(&f);
    f.lodc(["build", "part.glb", "-o", "part.lodc", "-q"]).ends(0);
    f.lodc(["extract", "part.lodc", "-o", "half.glb", "--ratio", "0.5", "-q"]).ends(0);
    let compare = |args: &[&str]| -> Value {
        let more = ["--json", "-q", "--samples", "2000", "--views", "0"];
        f.lodc(["compare"].iter().chain(args).chain(&more)).ends(0).json()
    };
    let same = compare(&["part.glb", "part.lodc"]);
    assert_eq!(same["triangles"]["a"], same["triangles"]["b"]);
    let half = compare(&["part.glb", "part.lodc", "--ratio", "50%"]);
    assert_eq!(half["triangles"]["b"], 240);
    let mesh = compare(&["part.lodc", "part.glb", "--ratio", "0.5"]);
    assert_eq!(half["triangles"]["b"], mesh["triangles"]["b"]);
    let levels = compare(&["part.lodc", "half.glb", "--level-a", "50%"]);
    assert_eq!(levels["triangles"]["a"], levels["triangles"]["b"]);
    assert!(levels["hausdorff"]["max"].as_f64() < Some(1e-6), "{levels}");
}

#[test]
fn scans_and_prints_are_read_like_any_mesh() {
    let f = Folder::new();
    part(&f);
    f.lodc(["extract", "part.glb", "--ratio", "1", "-o", "scan.ply", "-q"]).ends(0);
    let corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let facets: String = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        .iter()
        .map(|facet| {
            let vertex = |&i: &usize| {
                let [x, y, z] = corners[i];
                format!("vertex {x} {y} {z}\n")
            };
            let loop_: String = facet.iter().map(vertex).collect();
            format!("facet normal 0 0 0\nouter loop\n{loop_}endloop\nendfacet\n")
        })
        .collect();
    f.file("print.stl", format!("solid print\n{facets}endsolid print\n"));
    for (name, format, triangles) in [("scan.ply", "ply", 480), ("print.stl", "stl", 4)] {
        f.lodc(["build", name, "-o", "x.lodc", "-q"]).ends(0);
        f.lodc(["verify", "x.lodc", "--source", name]).ends(0);
        let info = f.lodc(["info", "x.lodc", "--json"]).ends(0).json();
        assert_eq!(info["source"]["format"], format);
        assert_eq!(info["objects"][0]["triangles"], triangles);
        // A level is the same from the mesh and from the file, and holds what it states.
        f.lodc(["extract", name, "--ratio", "50%", "-o", "a.ply", "-q"]).ends(0);
        f.lodc(["extract", "x.lodc", "--ratio", "50%", "-o", "b.glb", "-q"]).ends(0);
        f.lodc(["verify", "a.ply", "b.glb", "--source", name]).ends(0);
    }
    // Corners of loose triangles are joined, and a folder has all kinds.
    assert!(f.lodc(["build", "print.stl", "-o", "x.lodc"]).ends(0).err.contains("12 corners"));
    f.lodc(["build", ".", "--include", "*.{ply,stl}", "-o", "out"]).ends(0);
    assert!(f.has("out/scan.ply.lodc") && f.has("out/print.stl.lodc"));
    f.file("cut.ply", &f.read("scan.ply")[..2000]);
    let run = f.lodc(["build", "cut.ply"]).fails(3);
    assert!(run.err.contains("cut.ply: header: 360 `vertex` elements do not fit"), "{}", run.err);
}
