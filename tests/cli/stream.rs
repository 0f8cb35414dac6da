//! `lodc pack` and `lodc unpack`: streams whole, cut and damaged, through files and pipes.

use crate::support::{Folder, grid};

/// A folder with a grid, its `.lodc` and a stream of it.
fn folder() -> Folder {
    let f = Folder::new();
    f.file("g.obj", grid(12));
    f.lodc(["build", "g.obj"]).ends(0);
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
