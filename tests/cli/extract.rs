//! `lodc extract` and `lodc info`.

use crate::support::{Folder, grid, scene};
use serde_json::Value;

const PART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/machine_part.glb");

fn built(name: &str, text: &str) -> Folder {
    let f = Folder::new();
    f.file(name, text);
    f.lodc(["build", name, "-o", "m.lodc", "-q"]).ends(0);
    f
}

fn extracted(f: &Folder, selector: &[&str]) -> Value {
    let args = ["extract", "m.lodc", "-o", "out.glb", "--json", "-q"];
    f.lodc(args.iter().chain(selector)).ends(0).json()
}

#[test]
fn every_selector_keeps_its_promise() {
    let f = built("g.obj", &grid(16));
    assert_eq!(extracted(&f, &["--lod", "0"])["triangles"], 512);
    assert_eq!(extracted(&f, &["--ratio", "1"])["triangles"], 512);
    for (selector, most) in
        [(["--ratio", "0.25"], 128), (["--ratio", "0.1"], 51), (["--triangles", "77"], 77)]
    {
        let got = extracted(&f, &selector);
        let triangles = got["triangles"].as_u64().expect("a count");
        assert!(triangles <= most && triangles > most * 9 / 10, "{selector:?} gave {triangles}");
    }
    let one = extracted(&f, &["--triangles", "100", "--no-refit"]);
    let error = one["error"].to_string();
    let again = extracted(&f, &["--error", &error, "--no-refit"]);
    assert_eq!(again["error"], one["error"], "a printed error, typed again, is met");
    assert!(again["lod"].as_u64() >= one["lod"].as_u64());
    let finer = extracted(&f, &["--error", "0"]);
    assert_eq!(finer["error"], 0.0);
}

#[test]
fn the_report_has_its_keys() {
    let f = built("g.obj", &grid(6));
    let report = extracted(&f, &["--ratio", "0.5"]);
    for key in ["schema_version", "lod", "triangles", "vertices", "error", "output"] {
        assert!(report.get(key).is_some_and(|v| !v.is_null()), "{key} in {report}");
    }
    assert_eq!(report["output"], "out.glb");
}

#[test]
fn an_object_with_triangles_never_comes_back_empty() {
    let f = built("g.obj", &grid(6));
    for selector in
        [["--ratio", "0"], ["--triangles", "0"], ["--error", "1e30"], ["--error", "500%"]]
    {
        let args = ["extract", "m.lodc", "-o", "out.obj", "--json"];
        let run = f.lodc(args.iter().chain(&selector)).ends(0);
        assert!(run.json()["triangles"].as_u64() > Some(0), "{selector:?}");
        // No level without a triangle is within any error, so that an error is met as it stands.
        let stopped = selector[0] != "--error";
        assert_eq!(run.err.contains("stopped at"), stopped, "{selector:?}: {}", run.err);
    }
    let last = extracted(&f, &["--lod", "4000000000"]);
    assert_eq!(last["triangles"], 0, "a record number is taken literally");
}

#[test]
fn every_format_is_named_by_its_extension_and_every_model_gives_the_same_triangles() {
    let f = built("g.obj", &grid(8));
    for (name, magic) in [("o.glb", "glTF"), ("o.gltf", "{"), ("o.obj", ""), ("o.PLY", "ply\n")] {
        f.lodc(["extract", "m.lodc", "--ratio", "0.3", "--no-refit", "-o", name]).ends(0);
        assert!(f.read(name).starts_with(magic.as_bytes()), "{name}");
    }
    for model in ["speed", "masking", "interactive", "reference"] {
        let name = format!("{model}.obj");
        f.lodc(["extract", "m.lodc", "--ratio", "0.3", "--model", model, "-o", &name]).ends(0);
        assert_eq!(sorted_faces(&f.read(&name)), sorted_faces(&f.read("o.obj")), "{model}");
    }
    f.lodc(["build", "g.obj", "-o", "one.lodc", "--models", "interactive"]).ends(0);
    let run = f
        .lodc(["extract", "one.lodc", "--ratio", "0.3", "--model", "speed", "-o", "o.obj"])
        .fails(2);
    assert!(run.err.contains("interactive"), "says what there is: {}", run.err);
}

#[test]
fn levels_are_refitted_unless_they_are_asked_for_as_stored() {
    let f = Folder::new();
    f.file("p.glb", std::fs::read(PART).expect("a fixture"));
    f.lodc(["build", "p.glb", "-o", "m.lodc", "-q"]).ends(0);
    let refitted = |selector: &[&str]| extracted(&f, selector)["refitted"] == true;
    let lod = extracted(&f, &["--ratio", "20%"])["lod"].to_string();
    assert!(refitted(&["--ratio", "20%"]) && refitted(&["--triangles", "100"]));
    assert!(!refitted(&["--ratio", "20%", "--no-refit"]) && !refitted(&["--ratio", "1"]));
    assert!(!refitted(&["--lod", &lod]) && refitted(&["--lod", &lod, "--refit"]));
    assert!(!refitted(&["--ratio", "20%", "--model", "reference"]));
    let view = ["--criterion", "sphere", "--target", "0,0,0", "--radius", "1"];
    assert!(!refitted(&[&view[..], &["--ratio", "20%"]].concat()));
    assert!(!refitted(&["--ratio", "20%", "--refit", "--no-refit"]), "the last one counts");
}

#[test]
fn what_is_asked_of_errors_holds_for_refitted_levels() {
    let mut moved = 0;
    for (name, text) in [("g.obj", grid(16)), ("p.glb", String::new())] {
        let f = Folder::new();
        let bytes =
            if text.is_empty() { std::fs::read(PART).expect("a fixture") } else { text.into() };
        f.file(name, bytes);
        f.lodc(["build", name, "-o", "m.lodc", "-q"]).ends(0);
        for share in [0.5, 0.3, 0.2, 0.1, 0.05] {
            let plain = extracted(&f, &["--ratio", &share.to_string(), "--no-refit"]);
            for key in ["error", "rms"] {
                let wanted = plain[key].to_string();
                let level = extracted(&f, &[&format!("--{key}"), &wanted]);
                assert!(level[key].as_f64() <= plain[key].as_f64(), "{name} {key}: {level}");
                moved += u32::from(level["refitted"] == true);
            }
        }
    }
    assert!(moved > 5, "{moved} levels with other vertices");
}

fn sorted_faces(obj: &[u8]) -> Vec<Vec<String>> {
    let text = String::from_utf8_lossy(obj);
    let vertices: Vec<&str> = text.lines().filter_map(|l| l.strip_prefix("v ")).collect();
    let corner = |c: &str| {
        let index = c.split('/').next().and_then(|i| i.parse::<usize>().ok()).expect("an index");
        vertices[index - 1].to_owned()
    };
    let mut faces: Vec<Vec<String>> = text
        .lines()
        .filter_map(|l| l.strip_prefix("f "))
        .map(|l| {
            let mut corners: Vec<_> = l.split_whitespace().map(corner).collect();
            let first =
                (0..corners.len()).min_by_key(|&i| &corners[i]).expect("a face has corners");
            corners.rotate_left(first);
            corners
        })
        .collect();
    faces.sort();
    faces
}

#[test]
fn an_extraction_says_in_one_line_what_it_gave() {
    let f = built("g.obj", &grid(8));
    let run = f.lodc(["extract", "m.lodc", "--triangles", "40", "-o", "o.glb"]).ends(0);
    assert_eq!(run.err.lines().count(), 1, "{}", run.err);
    for part in ["o.glb", "LOD ", "triangles", "vertices", "error"] {
        assert!(run.err.contains(part), "{part} in {}", run.err);
    }
    f.lodc(["extract", "m.lodc", "--triangles", "40", "-o", "."]).ends(0);
    assert!(f.has("m.lodc.glb"), "an existing folder means inside");
}

#[test]
fn a_scene_is_met_as_a_whole_by_world_error() {
    let f = built("s.gltf", &scene(&[1.0, 8.0], 10));
    let whole = extracted(&f, &["--ratio", "0.4"]);
    let part = |i: usize, key: &str| whole["objects"][i][key].as_f64().expect("a number");
    assert!(whole["triangles"].as_u64() <= Some(160));
    assert!(whole["lod"].is_null(), "each object has its own");
    assert!(part(0, "triangles") < part(1, "triangles"), "detail goes where it shows: {whole}");
    let each = extracted(&f, &["--ratio", "0.4", "--per-object"]);
    assert_eq!(each["objects"][0]["triangles"], each["objects"][1]["triangles"]);
    let args = ["extract", "m.lodc", "-o", "out.glb", "--lod", "3"];
    assert!(f.lodc(args).fails(2).err.contains("--per-object"));
    f.lodc(args.iter().chain(&["--per-object"])).ends(0);
}

#[test]
fn info_has_its_keys_and_a_table_that_falls() {
    let f = built("s.gltf", &scene(&[1.0, 8.0], 10));
    let info = f.lodc(["info", "m.lodc", "--json"]).ends(0).json();
    for key in ["schema_version", "format_version", "key", "source", "objects"] {
        assert!(info.get(key).is_some_and(|v| !v.is_null()), "{key} in {info}");
    }
    assert_eq!(info["source"]["format"], "gltf");
    assert!(!info.to_string().contains("s.gltf"), "never a path");
    for object in info["objects"].as_array().expect("objects") {
        for key in [
            "name",
            "vertices",
            "referenced_vertices",
            "triangles",
            "submeshes",
            "fakes",
            "records",
            "steps",
        ] {
            assert!(object.get(key).is_some_and(|v| !v.is_null()), "{key} in {object}");
        }
        assert!(object["last_legal_lod"].is_u64() && object["strips"].is_object());
        let lods = object["lods"].as_array().expect("a table");
        assert!(lods.len() >= 5);
        let rows =
            lods.iter().map(|l| (l["lod"].as_u64(), l["triangles"].as_u64(), l["error"].as_f64()));
        let rows: Vec<_> = rows.collect();
        assert!(
            rows.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 >= w[1].1 && w[0].2 <= w[1].2),
            "{rows:?}"
        );
        let bits = &object["models"]["interactive"]["bits_per_vertex"];
        for key in ["thesis", "thesis_normals", "file"] {
            assert!(bits[key].as_f64() > Some(0.0), "{key} in {bits}");
        }
    }
    let with = f.lodc(["info", "m.lodc", "--json", "--baselines"]).ends(0).json();
    assert!(with["objects"][0]["models"]["triangles"]["bits_per_vertex"]["file"].is_null());
    let text = f.lodc(["info", "m.lodc"]).ends(0).text();
    assert!(
        text.contains("grid0") && text.contains("grid1") && text.contains("interactive"),
        "{text}"
    );
}

#[test]
fn a_whole_gltf_scene_comes_back() {
    let f = built("s.gltf", &scene(&[1.0, 8.0], 6));
    f.lodc(["extract", "m.lodc", "--ratio", "0.5", "-o", "half.gltf"]).ends(0);
    let half: Value = serde_json::from_slice(&f.read("half.gltf")).expect("JSON");
    assert_eq!(half["nodes"].as_array().map(Vec::len), Some(2));
    assert_eq!(half["nodes"][1]["translation"][0], 20.0);
    assert!(f.has("half.bin") || f.names().iter().any(|n| n.ends_with(".bin")), "{:?}", f.names());
    f.lodc(["build", "half.gltf", "-o", "half.lodc", "-q"]).ends(0);
}

/// A wall of one material and, far beside it, a pane of another, which goes first.
fn wall_and_pane() -> String {
    let wall = grid(12).replacen("f ", "usemtl wall\nf ", 1);
    let pane = "v 30 0 0\nv 36 0 0\nv 36 6 0\nv 30 6 0\nusemtl pane\nf -4 -3 -2 -1\n";
    wall + pane
}

#[test]
fn a_level_names_what_it_no_longer_shows() {
    let f = built("w.obj", &wall_and_pane());
    let report = |input: &str, level: &[&str]| {
        let args = ["extract", input, "-o", "l.glb", "--json"];
        let run = f.lodc(args.iter().chain(level)).ends(0);
        (run.json()["gone"].clone(), run.err)
    };
    let (gone, _) = report("m.lodc", &["--ratio", "50%"]);
    assert_eq!(gone, serde_json::json!([]));
    let (gone, warned) = report("m.lodc", &["--triangles", "1"]);
    let kinds: Vec<_> = gone.as_array().expect("a list").iter().map(|g| &g["kind"]).collect();
    assert!(kinds.iter().any(|kind| *kind == "material"), "{gone}");
    assert!(kinds.iter().any(|kind| *kind == "surface"), "{gone}");
    assert!(warned.contains("of the visible surface is gone"), "{warned}");
    // Of a scene whose objects have lost all their triangles.
    f.file("scene.gltf", scene(&[1.0, 2.0], 8));
    let (gone, warned) = report("scene.gltf", &["--lod", "999999", "--per-object"]);
    let named =
        |kind: &str, name: Value| serde_json::json!({"kind": kind, "name": name, "share": 1.0});
    let object = |name: &str| named("object", name.into());
    assert_eq!(
        gone,
        serde_json::json!([object("grid0"), object("grid1"), named("surface", Value::Null)])
    );
    assert!(warned.contains("the object grid0 is gone"), "{warned}");
}
