//! `lodc bench`: rows for everything, counts that can be worked out by hand, and documents that do
//! not change.

use crate::support::{Folder, grid, scene};
use serde_json::Value;

fn number(value: &Value, path: &str) -> f64 {
    value
        .pointer(path)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("no number at {path} in {value}"))
}

fn measured(f: &Folder, args: &[&str]) -> Value {
    let args = ["bench", "--json", "--effort", "fast", "--rounds", "1"].iter().chain(args);
    f.lodc(args).ends(0).json()
}

#[test]
fn every_row_has_its_numbers_and_they_agree_with_each_other() {
    let f = Folder::new();
    f.file("g.obj", grid(20));
    let report = measured(&f, &["g.obj"]);
    assert_eq!(
        (&report["schema_version"], &report["files"][0]["file"]),
        (&1.into(), &"g.obj".into())
    );
    assert_eq!(number(&report, "/steps"), 0.001);
    let object = &report["files"][0]["objects"][0];
    // 21 × 21 vertices, 800 triangles; one record fewer than vertices, and fewer than a thousand of
    // them.
    let (v, triangles, records) = (441.0, 800.0, 440.0);
    assert_eq!((number(object, "/referenced_vertices"), number(object, "/updates")), (v, records));
    let bits = |words: f64| 32.0 * words / v;
    let near = |path: &str, wanted: f64| {
        let found = number(object, path);
        assert!((found - wanted).abs() < 1e-6, "{path}: {found}, not {wanted}");
    };
    near("/models/triangles/bits_per_vertex/thesis", bits(3.0 * v + 3.0 * triangles));
    near("/models/triangles/bits_per_vertex/thesis_normals", bits(6.0 * v + 3.0 * triangles));
    let indices = number(object, "/primitives/stripe/indices");
    near("/models/strips/bits_per_vertex/thesis", bits(3.0 * v + indices));
    let mesh = 4.0 * v + 6.0 * triangles;
    near("/models/progressive_mesh/bits_per_vertex/thesis", bits(mesh + 8.0 * records));
    near("/models/progressive_mesh/bits_per_vertex/thesis_normals", bits(mesh + 14.0 * records));
    near("/models/interactive/bits_per_vertex/thesis", bits(3.0 * v + 3.0 * triangles + records));
    near(
        "/models/interactive/bits_per_vertex/thesis_95",
        bits(3.0 * v + 3.0 * triangles + 0.95 * records),
    );
    near("/primitives/triangles/indices_per_triangle", 3.0);
    near("/primitives/triangles_cache/indices", 3.0 * triangles);
    // Lists draw what is left; strips have become Speed Strips, at least as long as what they draw.
    near("/primitives_20/triangles/indices_per_triangle", 3.0);
    let left = number(object, "/primitives_20/triangles/indices") / 3.0;
    assert!(left <= triangles / 5.0 && left > triangles / 6.0, "{left}");
    near("/primitives_20/triangles_cache/indices", 3.0 * left);
    for kind in ["stripe", "cache"] {
        let of = |key: &str| number(object, &format!("/primitives_20/{kind}/{key}"));
        assert!(of("strips") >= 1.0 && of("indices") >= left + 2.0 * of("strips"), "{kind}");
    }
    near("/models/interactive/drawn/indices_per_triangle", 3.0);
    near("/models/interactive/traffic/bytes_per_update", 4.0);
    near("/models/progressive_mesh/extraction/per_progressive_mesh", 1.0);
    assert!(
        object["models"]["discrete"]["extraction"].is_null()
            && object["models"]["discrete"]["traffic"].is_null()
    );
    assert!(object["models"]["progressive_mesh"]["bits_per_vertex"]["file"].is_null());
    for (name, row) in object["models"].as_object().expect("rows") {
        check_model(object, name, row);
    }
}

/// The numbers of one model of a row: there, positive and consistent.
fn check_model(object: &Value, name: &str, row: &Value) {
    let (thesis, normals) =
        (number(row, "/bits_per_vertex/thesis"), number(row, "/bits_per_vertex/thesis_normals"));
    assert!(
        thesis > 0.0 && normals > thesis && number(row, "/bits_per_vertex/thesis_95") <= thesis,
        "{name}"
    );
    if row["baseline"] == false {
        assert!(number(row, "/bits_per_vertex/file") > 0.0, "{name}");
    }
    if !row["extraction"].is_null() {
        let [coarser, finer, mean] =
            ["coarser", "finer", "mean"].map(|t| number(row, &format!("/extraction/{t}_us")));
        assert!(
            coarser > 0.0 && finer > 0.0 && (mean - (coarser + finer) / 2.0).abs() < 1e-9,
            "{name}"
        );
        let jump = number(row, "/extraction/jump_us") / number(object, "/rebuild_us");
        assert!((jump - number(row, "/extraction/jump_per_rebuild")).abs() < 1e-9, "{name}");
        assert!(number(row, "/drawn/indices_per_lod") > 0.0, "{name}");
    }
}

#[test]
fn timings_have_a_mean_and_a_spread_beside_the_best() {
    let f = Folder::new();
    f.file("g.obj", grid(8));
    let timed = |rounds: &str| {
        let args = ["bench", "--json", "--effort", "fast", "--streams", "--rounds", rounds];
        let report = f.lodc(args.iter().chain(&["g.obj"])).ends(0).json();
        report["files"][0]["objects"][0].clone()
    };
    let object = timed("3");
    let extraction = &object["models"]["interactive"]["extraction"];
    for (within, best, spread, rounds) in [
        (extraction, "/coarser_us", "/spread/coarser", 3.0),
        (extraction, "/jump_us", "/spread/jump", 15.0),
        (&object, "/rebuild_us", "/rebuild_spread", 15.0),
        (&object, "/stream/speed/decode_ms", "/stream/speed/decode_spread", 3.0),
    ] {
        let of = |field: &str| number(within, &format!("{spread}/{field}"));
        assert_eq!(of("rounds"), rounds, "{spread}");
        // The mean is rounded: a hair below the best if all rounds are equal.
        assert!(of("mean") >= number(within, best) * (1.0 - 1e-12), "{spread}");
        assert!(of("deviation") >= 0.0, "{spread}");
    }
    let single = timed("1");
    let finer = &single["models"]["speed"]["extraction"]["spread"]["finer"];
    assert!(number(finer, "/mean") > 0.0 && finer["deviation"].is_null(), "{finer}");
}

#[test]
fn without_times_the_document_is_the_same_with_any_number_of_threads() {
    let f = Folder::new();
    f.file("g.obj", grid(12));
    f.file("s.gltf", scene(&[1.0, 3.0], 5));
    let run = |jobs: &str| {
        f.lodc(["bench", "--json", "--no-times", "--jobs", jobs, "g.obj", "s.gltf"]).ends(0).out
    };
    let one = run("1");
    assert!(one == run("3"));
    let report: Value = serde_json::from_slice(&one).expect("JSON");
    assert_eq!(report["files"][1]["objects"].as_array().map(Vec::len), Some(2));
    let models = &report["files"][1]["objects"][1]["models"];
    assert!(
        models["interactive"]["extraction"].is_null()
            && models["interactive"]["traffic"].is_object()
    );
}

#[test]
fn streams_are_measured_where_they_are_asked_for() {
    let f = Folder::new();
    f.file("g.obj", grid(16));
    assert!(measured(&f, &["g.obj", "--no-times"])["files"][0]["objects"][0]["stream"].is_null());
    let report = measured(&f, &["g.obj", "--streams"]);
    let stream = &report["files"][0]["objects"][0]["stream"];
    let bits = ["lossless", "lossless_exact", "packages", "packages_normals"]
        .map(|key| number(stream, &format!("/{key}")));
    assert!(bits.is_sorted() && bits[0] > 0.0, "{bits:?}");
    assert!(number(stream, "/quantized") > 0.0);
    assert!(
        number(stream, "/speed/decode_ms") > 0.0
            && number(stream, "/speed/encode_million_triangles_per_second") > 0.0
    );
    let prefixes = stream["prefixes"].as_array().expect("prefixes");
    assert_eq!(
        prefixes.iter().map(|p| number(p, "/percent")).collect::<Vec<_>>(),
        [1.0, 2.0, 5.0, 10.0, 25.0, 50.0]
    );
    let triangles: Vec<f64> = prefixes.iter().map(|p| number(p, "/triangles")).collect();
    assert!(triangles.is_sorted() && triangles[5] > 0.0 && triangles[5] < 512.0, "{triangles:?}");
    let (half, bytes) = (number(&prefixes[5], "/bytes"), number(stream, "/bytes"));
    assert!((2.0 * half - bytes).abs() <= 2.0, "{half} of {bytes} bytes");
    let last = &prefixes[5];
    assert!(number(last, "/hausdorff") >= number(last, "/rms") && number(last, "/image") >= 0.0);
    let run = || {
        f.lodc(["bench", "--json", "--no-times", "--streams", "--effort", "fast", "g.obj"])
            .ends(0)
            .out
    };
    assert!(run() == run());
}

#[test]
fn a_lodc_file_and_its_source_measure_the_same() {
    let f = Folder::new();
    f.file("g.obj", grid(10));
    f.lodc(["build", "g.obj", "-o", "g.lodc", "-q", "--effort", "fast"]).ends(0);
    let [source, file] = ["g.obj", "g.lodc"]
        .map(|name| measured(&f, &["--no-times", name])["files"][0]["objects"].clone());
    assert_eq!(source, file);
    let chosen = measured(&f, &["--no-times", "--models", "interactive", "g.lodc"]);
    assert!(chosen["files"][0]["objects"][0]["models"]["interactive"].is_object());
}

#[test]
fn wider_steps_make_fewer_updates() {
    let f = Folder::new();
    f.file("g.obj", grid(10));
    let updates = |steps: &str| {
        let report = measured(&f, &["--no-times", "--steps", steps, "g.obj"]);
        report["files"][0]["objects"][0]["updates"].as_u64()
    };
    assert_eq!((updates("5%"), updates("50"), updates("100%")), (Some(20), Some(2), Some(1)));
    for wrong in ["0", "-1%", "101%", "x", "nan"] {
        f.lodc(["bench", "g.obj", "--steps", wrong]).ends(2);
    }
}

#[test]
fn a_bad_input_does_not_keep_the_others_from_their_turn() {
    let f = Folder::new();
    f.file("bad.obj", "f 1 2 3\n");
    f.file("none.obj", "v 0 0 0\nv 1 0 0\nf 1 1 2\n");
    f.file("g.obj", grid(4));
    let run = f.lodc(["bench", "--json", "--rounds", "1", "bad.obj", "none.obj", "g.obj"]).ends(3);
    assert_eq!(run.errors(), 1, "{}", run.err);
    let report = run.json();
    assert!(report["files"][0]["error"].is_string() && report["files"][1]["error"].is_null());
    assert!(number(&report, "/files/2/objects/0/models/progressive_mesh/extraction/mean_us") > 0.0);
}

#[test]
fn people_get_tables_with_the_same_rows() {
    let f = Folder::new();
    f.file("g.obj", grid(6));
    let text = f.lodc(["bench", "--rounds", "1", "g.obj"]).ends(0).text();
    for row in
        ["interactive", "progressive_mesh", "discrete", "triangles", "strips", "stripe", "cache"]
    {
        assert!(text.lines().any(|line| line.trim_start().starts_with(row)), "no {row} in {text}");
    }
}

#[test]
fn info_counts_the_same_baselines() {
    let f = Folder::new();
    f.file("g.obj", grid(8));
    f.lodc(["build", "g.obj", "-o", "g.lodc", "-q"]).ends(0);
    let info = f.lodc(["info", "g.lodc", "--json", "--baselines"]).ends(0).json();
    let bench = f.lodc(["bench", "g.lodc", "--json", "--no-times"]).ends(0).json();
    let [info, bench] = [&info["objects"][0]["models"], &bench["files"][0]["objects"][0]["models"]];
    let names = |models: &Value| models.as_object().map(|m| m.keys().cloned().collect::<Vec<_>>());
    assert_eq!(names(info), names(bench));
    for name in names(info).expect("rows") {
        for key in ["thesis", "thesis_normals", "file"] {
            assert_eq!(
                info[&name]["bits_per_vertex"][key], bench[&name]["bits_per_vertex"][key],
                "{name} {key}"
            );
        }
    }
}

/// The parts that do not depend on the clock: which cases there are, and the memory, worked out by
/// hand.
#[test]
fn a_device_is_timed_in_every_model_and_its_memory_counted() {
    let f = Folder::new();
    f.file("g.obj", grid(20));
    let run = f.lodc(["bench", "g.obj", "--json", "--effort", "fast", "--rounds", "1", "--gpu"]);
    let Some(run) = run.drawn() else { return };
    let report = run.json();
    let gpu = &report["files"][0]["objects"][0]["gpu"];
    assert!(
        gpu["adapter"].is_string() && (gpu["clock"] == "device" || gpu["clock"] == "host"),
        "{gpu}"
    );
    for (model, cases, others) in [("speed", 1, 2), ("masking", 1, 2), ("interactive", 9, 2)] {
        let timed = gpu["models"][model].as_object().expect("cases").values();
        assert!(
            timed
                .clone()
                .all(|case| number(case, "/milliseconds") > 0.0 && number(case, "/bytes") > 0.0),
            "{model}"
        );
        let passes = timed.filter(|case| case["million_vertices_per_second"].is_number()).count();
        assert!(passes >= cases, "{model}: {passes}");
        assert_eq!(
            gpu["models"][model].as_object().map(|all| all.len() - passes),
            Some(others),
            "{model}"
        );
    }
    let curve = &gpu["curve"];
    let lods = curve["lods"].as_array().expect("LODs").len();
    let structures = curve["structures"].as_object().expect("structures");
    let names: Vec<&str> = structures.keys().map(String::as_str).collect();
    assert_eq!(names, ["interactive", "lodstrips", "masking", "progressive_mesh", "speed"]);
    for (name, drawn) in structures {
        for key in ["draw_ms", "bytes", "upload_ms", "single_bytes", "single_upload_ms"] {
            assert_eq!(drawn[key].as_array().map(Vec::len), Some(lods), "{name} {key}");
        }
        assert!(number(drawn, "/draw_ms/0") > 0.0 && number(drawn, "/bytes/0") > 0.0, "{name}");
    }
    let primitives = gpu["primitives"].as_object().expect("primitives");
    let names: Vec<&str> = primitives.keys().map(String::as_str).collect();
    assert_eq!(names, ["cache", "stripe", "triangles", "triangles_cache"]);
    for draws in primitives.values() {
        assert!(number(draws, "/draw_ms") > 0.0 && number(draws, "/draw_ms_20") > 0.0);
    }
    let words = |path: &str| 441.0 * number(&gpu["words_per_vertex"], path);
    let (v, f) = (441.0, 800.0);
    // Points, links, records and triangles, and the LODs by error; the attributes' source only if
    // there are any.
    let near =
        |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-6, "{found}, not {wanted}");
    near(words("/interactive/view-dependent/positions"), 9.0 * v + 3.0 * f + 7168.0);
    near(words("/interactive/view-dependent/normals"), 18.0 * v + 3.0 * f + 7168.0);
    // Two copies of the records have a normal more.
    let continuous = words("/interactive/continuous/positions");
    near(words("/interactive/continuous/normals"), continuous + 6.0 * v);
    assert!(continuous > 9.0 * v + 3.0 * f && continuous < 30.0 * v, "{continuous}");
    near(words("/masking/masks/normals"), words("/masking/masks/positions") + 3.0 * v);
}

#[test]
fn curves_over_levels_have_a_point_for_each_of_their_lods() {
    let f = Folder::new();
    f.file("g.obj", grid(12));
    let run = f.lodc(["bench", "g.obj", "--no-times", "--json"]).ends(0).json();
    let object = &run["files"][0]["objects"][0];
    let list = |value: &Value| -> Vec<u64> {
        let list = value.as_array().expect("a list");
        list.iter().map(|v| v.as_u64().expect("a count")).collect()
    };
    let (lods, triangles) = (list(&object["curve"]["lods"]), list(&object["curve"]["triangles"]));
    assert!(lods.windows(2).all(|p| p[0] < p[1]) && triangles.windows(2).all(|p| p[0] >= p[1]));
    assert_eq!(lods.len(), 100);
    let interactive = list(&object["models"]["interactive"]["drawn"]["curve"]);
    assert_eq!(interactive, triangles.iter().map(|t| 3 * t).collect::<Vec<_>>());
    for name in ["speed", "masking", "lodstrips", "discrete", "progressive_mesh"] {
        let curve = list(&object["models"][name]["drawn"]["curve"]);
        assert_eq!(curve.len(), lods.len(), "{name}");
    }
    let timed =
        f.lodc(["bench", "g.obj", "--rounds", "1", "--json", "--plots", "p"]).ends(0).json();
    let models = &timed["files"][0]["objects"][0]["models"];
    for name in ["speed", "masking", "interactive", "lodstrips", "progressive_mesh"] {
        let curve = models[name]["extraction"]["curve_us"].as_array().expect("a curve");
        assert_eq!(curve.len(), lods.len(), "{name}");
        assert!(curve.iter().all(|t| t.as_f64().is_some_and(|t| t > 0.0)), "{name}");
    }
    let read = |name: &str| String::from_utf8(f.read(&format!("p/{name}"))).expect("text");
    assert!(read("g-indices.svg").contains(">discrete<"));
    assert!(!read("g-extraction.svg").contains(">discrete<"), "it shows five levels alone");
    assert!(!f.has("p/g-draw.svg"), "nothing was drawn");
    f.lodc(["bench", "g.obj", "g.obj", "--no-times", "--plots", "q"]).ends(0);
    assert!(f.has("q/g-indices.svg") && f.has("q/g-2-indices.svg") && !f.has("q/g-extraction.svg"));
    let share = number(object, "/models/speed/traffic/length_changes");
    assert!((0.05..0.95).contains(&share), "{share}");
    assert!(object["models"]["masking"]["traffic"]["length_changes"].is_null());
}
