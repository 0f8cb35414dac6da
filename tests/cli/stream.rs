//! `lodc pack` and `lodc unpack`: streams whole, cut and damaged, through files and pipes.

use crate::support::{Folder, grid};

/// A folder with a grid, its `.lodc` and a stream of it.
fn folder() -> Folder {
    let f = Folder::new();
    f.file("g.obj", grid(12));
    f.lodc(["build", "g.obj", "-o", "g.lodc"]).ends(0);
    f.lodc(["pack", "g.lodc", "-o", "g.lods"]).ends(0);
    f
}

/// The triangles of an OBJ by the text of their corners' positions, sorted.
fn triangles(obj: &[u8]) -> Vec<[String; 3]> {
    let text = String::from_utf8(obj.to_vec()).expect("OBJ is text");
    let positions: Vec<&str> = text.lines().filter(|l| l.starts_with("v ")).collect();
    let corner = |c: &str| {
        let number: usize = c.split('/').next().and_then(|n| n.parse().ok()).expect("a vertex");
        positions[number - 1].to_owned()
    };
    let faces = text.lines().filter_map(|l| l.strip_prefix("f "));
    let mut all: Vec<[String; 3]> = faces
        .map(|f| {
            let c: Vec<String> = f.split_whitespace().map(corner).collect();
            let turned = (0..3).map(|i| [0, 1, 2].map(|k| c[(i + k) % 3].clone()));
            turned.min().expect("three ways to turn it")
        })
        .collect();
    all.sort();
    all
}

#[test]
fn a_whole_stream_gives_back_the_whole_mesh() {
    let f = folder();
    f.lodc(["extract", "g.lodc", "--lod", "0", "-o", "fine.obj"]).ends(0);
    f.lodc(["unpack", "g.lods", "--whole", "-o", "out.obj"]).ends(0);
    assert_eq!(triangles(&f.read("out.obj")), triangles(&f.read("fine.obj")));
}

#[test]
fn a_prefix_is_a_mesh_and_a_note_unless_the_whole_is_wanted() {
    let f = folder();
    let stream = f.read("g.lods");
    let mut before = 0;
    for tenth in 3..10 {
        f.file("part.lods", &stream[..stream.len() * tenth / 10]);
        let run = f.lodc(["unpack", "part.lods", "-o", "part.obj", "--json"]).ends(0);
        let report = run.json();
        assert_eq!(
            (&report["whole"], &report["damaged"]),
            (&false.into(), &serde_json::Value::Null)
        );
        let shown = report["objects"][0]["triangles"].as_u64().expect("a number");
        assert!(shown >= before && shown < 288, "{shown} triangles after {tenth} tenths");
        assert_eq!(triangles(&f.read("part.obj")).len() as u64, shown);
        before = shown;
        f.lodc(["unpack", "part.lods", "-o", "whole.obj", "--whole"]).ends(3);
    }
    assert!(before > 100, "only {before} triangles after nine tenths");
    assert!(!f.has("whole.obj"));
    f.file("none.lods", &stream[..20]);
    f.lodc(["unpack", "none.lods", "-o", "none.obj"]).ends(3);
}

#[test]
fn damage_is_found_and_the_sound_part_written() {
    let f = folder();
    let mut stream = f.read("g.lods");
    let at = stream.len() * 3 / 4;
    stream[at] ^= 16;
    f.file("bad.lods", &stream);
    let run = f.lodc(["unpack", "bad.lods", "-o", "bad.obj"]).ends(3);
    assert!(run.err.contains("checksum"), "{}", run.err);
    assert!(!triangles(&f.read("bad.obj")).is_empty());
    f.lodc(["unpack", "bad.lods", "-o", "whole.obj", "--whole"]).ends(3);
    assert!(!f.has("whole.obj"));
    f.file("not.lods", "v 0 0 0\n");
    f.lodc(["unpack", "not.lods", "-o", "not.obj"]).ends(3);
}

#[test]
fn streams_go_through_pipes() {
    let f = folder();
    let packed = f.lodc_with(["pack", "-", "-o", "-"], &f.read("g.lodc")).ends(0);
    assert_eq!(packed.out, f.read("g.lods"));
    let glb = f.lodc_with(["unpack", "-", "-o", "-"], &packed.out).ends(0);
    assert_eq!(&glb.out[..4], b"glTF");
    f.lodc(["pack", "g.lodc", "-o", "-", "--json"]).ends(2);
}

#[test]
fn quantising_says_how_far_things_move() {
    let f = folder();
    let report =
        f.lodc(["pack", "g.lodc", "-o", "q.lods", "--quantize", "pos=3", "--json"]).ends(0).json();
    let object = &report["objects"][0];
    let bound = object["bounds"][0]["coordinate"].as_f64().expect("a bound");
    // Half of one of seven steps over twelve units.
    assert!((bound - 12.0 / 14.0).abs() < 1e-5, "{bound}");
    assert!(
        object["bits_per_vertex"]["stream"].as_f64()
            < object["bits_per_vertex"]["packages"].as_f64()
    );
    assert!(f.read("q.lods").len() < f.read("g.lods").len());
    f.lodc(["unpack", "q.lods", "--whole", "-o", "q.obj"]).ends(0);
    f.lodc(["pack", "g.lodc", "-o", "q.lods", "--quantize", "pos=99"]).ends(2);
}

#[test]
fn a_complete_stream_becomes_a_file_again_with_the_same_levels_and_models() {
    let f = folder();
    f.lodc(["pack", "g.lodc", "-o", "g.lods", "--exact"]).ends(0);
    f.lodc(["unpack", "g.lods", "-o", "again.lodc", "-q"]).ends(0);
    f.lodc(["verify", "again.lodc", "-q"]).ends(0);
    let objects = |name: &str| {
        let info = f.lodc(["info", name, "--json"]).ends(0).json();
        assert_eq!(info["format"], "lodc");
        info["objects"].clone()
    };
    let (again, before) = (&objects("again.lodc")[0], &objects("g.lodc")[0]);
    for key in ["triangles", "vertices", "fakes", "records", "steps", "last_legal_lod", "errors"] {
        assert_eq!(again[key], before[key], "{key}");
    }
    let table = |o: &serde_json::Value| o["lods"].as_array().expect("a table").clone();
    for (a, b) in table(again).iter().zip(&table(before)) {
        assert_eq!((&a["lod"], &a["triangles"]), (&b["lod"], &b["triangles"]));
        // Triangles come in another order, so that other samples are measured.
        for key in ["error", "rms"] {
            let [a, b] = [a, b].map(|lod| lod[key].as_f64().expect("measured"));
            assert!((a - b).abs() <= 0.05 * b + 1e-6, "{key}: {a} and {b}");
        }
    }
    let names = |o: &serde_json::Value| o["models"].as_object().expect("models").len();
    assert_eq!((names(again), names(before)), (3, 3));
    for lod in ["0", "40", "100"] {
        for name in ["again", "g"] {
            let (input, output) = (format!("{name}.lodc"), format!("{name}.obj"));
            f.lodc(["extract", &input, "--lod", lod, "-o", &output, "-q"]).ends(0);
        }
        assert_eq!(triangles(&f.read("again.obj")), triangles(&f.read("g.obj")), "LOD {lod}");
    }
    f.lodc(["unpack", "g.lods", "-o", "none.lodc", "--models", "none", "-q"]).ends(0);
    assert_eq!(names(&objects("none.lodc")[0]), 0);
    f.lodc(["unpack", "g.lods", "-o", "m.obj", "--models", "none"]).ends(2);
}

#[test]
fn a_file_in_the_order_of_a_stream_comes_back_byte_for_byte() {
    let f = folder();
    let report = f.lodc(["pack", "g.lodc", "-o", "g.lods", "--json"]).ends(0).json();
    let of = |key: &str| report["objects"][0][key].as_u64().expect("a number");
    let (levels, exact) = (of("levels"), of("exact_levels"));
    assert!(exact >= 10 && exact < levels, "{exact} of {levels} levels");
    let said = f.lodc(["pack", "g.lodc", "-o", "g.lods"]).ends(0).err;
    assert!(
        said.contains(&format!("{exact} of the file's {levels} levels are kept exactly")),
        "{said}"
    );
    f.lodc(["unpack", "g.lods", "-o", "a.lodc", "-q"]).ends(0);
    f.lodc(["verify", "a.lodc", "-q"]).ends(0);
    f.lodc(["pack", "a.lodc", "-o", "a.lods", "-q"]).ends(0);
    f.lodc(["unpack", "a.lods", "-o", "b.lodc", "-q"]).ends(0);
    assert_eq!(f.read("b.lodc"), f.read("a.lodc"));
    f.lodc(["pack", "b.lodc", "-o", "b.lods", "-q"]).ends(0);
    assert_eq!(f.read("b.lods"), f.read("a.lods"));
    assert!(f.read("a.lods").len().abs_diff(f.read("g.lods").len()) < 40);
}

#[test]
fn a_file_built_in_the_order_of_streams_comes_back_byte_for_byte_at_once() {
    let f = folder();
    let fixtures = ["machine_part.glb", "skinned_tube_u8.glb", "morphing_sphere.glb"];
    for name in fixtures {
        let path = format!("{}/../fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
        f.file(name, std::fs::read(path).expect("a fixture"));
    }
    for input in fixtures.into_iter().chain(["g.obj"]) {
        f.lodc(["build", input, "--sequence", "stream", "-o", "a.lodc", "-q"]).ends(0);
        f.lodc(["verify", "a.lodc", "--source", input, "-q"]).ends(0);
        let report = f.lodc(["pack", "a.lodc", "-o", "a.lods", "--json"]).ends(0).json();
        for object in report["objects"].as_array().expect("objects") {
            assert_eq!(object["exact_levels"], object["levels"], "{input}");
        }
        f.lodc(["unpack", "a.lods", "-o", "b.lodc", "-q"]).ends(0);
        assert!(f.read("b.lodc") == f.read("a.lodc"), "{input}");
    }
}

#[test]
fn a_file_needs_the_whole_stream() {
    let f = folder();
    let mut stream = f.read("g.lods");
    f.file("part.lods", &stream[..stream.len() / 2]);
    let refused = f.lodc(["unpack", "part.lods", "-o", "out.lodc"]).ends(3);
    assert!(refused.err.contains("not complete"), "{}", refused.err);
    assert_eq!(refused.err.lines().count(), 1, "{}", refused.err);
    let at = stream.len() * 3 / 4;
    stream[at] ^= 16;
    f.file("bad.lods", &stream);
    f.lodc(["unpack", "bad.lods", "-o", "out.lodc"]).ends(3);
    assert!(!f.has("out.lodc"));
}

#[test]
fn a_quantised_stream_gives_a_file_that_holds_or_none() {
    let f = folder();
    for (bits, status) in [(20, 0), (3, 3)] {
        let quantize = format!("pos={bits}");
        f.lodc(["pack", "g.lodc", "-o", "q.lods", "--quantize", &quantize]).ends(0);
        let run = f.lodc(["unpack", "q.lods", "-o", "q.lodc"]).ends(status);
        assert_eq!(f.has("q.lodc"), status == 0, "{}", run.err);
        if status == 0 {
            f.lodc(["verify", "q.lodc", "-q"]).ends(0);
            std::fs::remove_file(f.join("q.lodc")).expect("it is there");
        } else {
            assert!(run.err.contains("its levels do not hold"), "{}", run.err);
        }
    }
}

#[test]
fn info_says_what_has_come_of_a_stream() {
    let f = folder();
    let whole = f.lodc(["info", "g.lods", "--json"]).ends(0).json();
    assert_eq!((&whole["format"], &whole["whole"]), (&"lods".into(), &true.into()));
    let mut stream = f.read("g.lods");
    f.file("part.lods", &stream[..stream.len() / 2]);
    let part = f.lodc(["info", "part.lods", "--json"]).ends(0).json();
    let (shown, of) = (&part["objects"][0]["triangles"], &part["objects"][0]["of_triangles"]);
    assert!(shown.as_u64() > Some(0) && shown.as_u64() < of.as_u64(), "{part}");
    assert_eq!(of, &whole["objects"][0]["triangles"]);
    assert!(f.lodc(["info", "part.lods"]).ends(0).text().contains("a prefix"));
    let at = stream.len() / 2;
    stream[at] ^= 1;
    f.file("bad.lods", &stream);
    let bad = f.lodc(["info", "bad.lods", "--json"]).ends(3);
    assert!(bad.json()["damaged"].as_str().is_some_and(|what| what.contains("checksum")));
}

#[test]
fn info_of_several_is_a_list_and_one_bad_file_does_not_stop_it() {
    let f = folder();
    f.file("bad.lodc", "not a file");
    let run = f.lodc(["info", "g.lodc", "bad.lodc", "g.lods", "--json"]).ends(3);
    let document = run.json();
    let results = document["results"].as_array().expect("a list");
    assert_eq!(document["status"], 3);
    let inputs: Vec<_> = results.iter().map(|r| r["input"].clone()).collect();
    assert_eq!(inputs, ["g.lodc", "bad.lodc", "g.lods"]);
    assert_eq!((&results[0]["format"], &results[2]["format"]), (&"lodc".into(), &"lods".into()));
    assert!(results[1]["error"].is_string() && results[1]["status"] == 3);
    std::fs::remove_file(f.join("bad.lodc")).expect("it is there");
    let folder = f.lodc(["info", ".", "--exclude", "*.lods", "--json"]).ends(0).json();
    assert_eq!(folder["results"].as_array().map(Vec::len), Some(1));
    f.lodc(["info", ".", "--include", "*.none"]).ends(3);
    assert!(f.lodc(["info", "."]).ends(0).text().contains("stream of version"));
}
