//! `lodc build`: what it writes, says and reports.

use crate::support::{Folder, grid, scene};
use serde_json::Value;

#[test]
fn a_first_call_ends_with_a_summary_and_a_hint_that_works() {
    let f = Folder::new();
    f.file("grid.obj", grid(12));
    let run = f.lodc(["build", "grid.obj", "-o", "grid.lodc"]).ends(0);
    assert!(run.out.is_empty(), "standard output is for results");
    for part in [
        "288 triangles",
        "169 vertices",
        "1 submesh",
        "duplicated at seams",
        "valid down to LOD",
        "50 %",
        "1 %",
        "KiB",
    ] {
        assert!(run.err.contains(part), "{part} in\n{}", run.err);
    }
    let hint = run.err.lines().find_map(|l| l.trim().strip_prefix("next: lodc ")).expect("a hint");
    f.lodc(hint.split(' ')).ends(0);
    assert_eq!(f.names(), ["grid.10percent.glb", "grid.lodc", "grid.obj"]);
}

#[test]
fn quiet_is_silent_and_verbose_tells_every_stage() {
    let f = Folder::new();
    f.file("grid.obj", grid(4));
    let quiet = f.lodc(["build", "grid.obj", "-o", "grid.lodc", "-q"]).ends(0);
    assert!(quiet.out.is_empty() && quiet.err.is_empty(), "{}", quiet.err);
    let verbose = f.lodc(["build", "grid.obj", "-o", "grid.lodc", "-v"]).ends(0);
    for stage in ["import", "simplify", "errors", "models", "check", "write"] {
        assert!(verbose.err.contains(stage), "{stage} in\n{}", verbose.err);
    }
}

#[test]
fn the_report_has_its_keys_and_counts_that_fit_together() {
    let f = Folder::new();
    f.file("grid.obj", grid(10));
    let report =
        f.lodc(["build", "grid.obj", "-o", "grid.lodc", "--report", "json", "-q"]).ends(0).json();
    assert_eq!(report["schema_version"], 1);
    assert_eq!(report["tool_version"], env!("CARGO_PKG_VERSION"));
    let one = &report["inputs"][0];
    assert_eq!(one["input"], "grid.obj");
    assert_eq!(one["output"], "grid.lodc");
    assert_eq!(one["status"], 0);
    assert_eq!(one["error"], Value::Null);
    assert_eq!(one["triangles"], 200);
    assert_eq!(one["referenced_vertices"], 121);
    assert_eq!(one["submeshes"], 1);
    let number = |key: &str| one[key].as_u64().unwrap_or_else(|| panic!("{key} in {one}"));
    assert_eq!(number("vertices"), 121 + number("fakes"));
    assert_eq!(number("records"), number("vertices") - 1);
    assert!(number("steps") <= number("records") && number("last_legal_lod") <= number("records"));
    assert!(number("peak_bytes") > 0 || !cfg!(target_os = "linux"));
    assert_eq!(number("bytes"), f.read("grid.lodc").len() as u64);
    let stages: Vec<_> =
        one["stages"].as_array().expect("stages").iter().map(|s| s["name"].clone()).collect();
    assert_eq!(stages, ["import", "simplify", "errors", "strips", "models", "check", "write"]);
    assert!(
        one["stages"].as_array().expect("stages").iter().all(|s| s["seconds"].as_f64().is_some())
    );
    assert!(one["warnings"].is_array());
}

#[test]
fn a_bad_input_does_not_stop_the_others_and_the_worst_status_counts() {
    let f = Folder::new();
    f.file("good.obj", grid(3));
    f.file("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    f.file("worse.glb", "glTF");
    let args = [
        "build",
        "bad.obj",
        "good.obj",
        "worse.glb",
        "missing.obj",
        "-o",
        "out",
        "--report",
        "json",
    ];
    let run = f.lodc(args).ends(3);
    let report = run.json();
    let statuses: Vec<_> =
        report["inputs"].as_array().expect("inputs").iter().map(|i| i["status"].clone()).collect();
    assert_eq!(statuses, [3, 0, 3, 3]);
    assert!(
        report["inputs"][0]["error"]
            .as_str()
            .is_some_and(|e| e.contains("bad.obj") && e.contains("line 4"))
    );
    assert_eq!(run.errors(), 3, "{}", run.err);
    let made: Vec<_> = std::fs::read_dir(f.join("out"))
        .expect("made")
        .map(|e| e.expect("an entry").file_name())
        .collect();
    assert_eq!(made, ["good.obj.lodc"]);
}

#[test]
fn a_limit_ends_with_5_and_says_which() {
    let f = Folder::new();
    f.file("grid.obj", grid(10));
    for key in ["file", "total", "vertices", "triangles", "memory", "line"] {
        let low = format!("{key}=3");
        let run = f.lodc(["build", "grid.obj", "--limit", &low]).fails(5);
        assert!(run.err.contains("grid.obj"), "{}", run.err);
        // Of several the last one counts.
        let raised = ["--limit", &low, "--limit", &format!("{key}=8G")];
        f.lodc(["build", "grid.obj", "-o", "grid.lodc"].iter().chain(&raised)).ends(0);
    }
    std::fs::remove_file(f.join("grid.lodc")).expect("built");
    for wrong in ["memory", "memory=much", "size=1", "=1"] {
        let run = f.lodc(["build", "grid.obj", "--limit", wrong]).fails(2);
        assert_eq!(run.err.lines().count(), 1, "{}", run.err);
        assert!(
            run.err.contains("file, total, line, vertices, triangles, memory, pixels, time"),
            "{}",
            run.err
        );
    }
    for (stage, options) in [
        ("models", ["--models", "speed,masking,interactive"]),
        ("errors", ["--models", "none"]),
        ("simplify", ["--metric", "kl"]),
    ] {
        let run = f
            .lodc(
                ["build", "grid.obj", "-o", "grid.lodc", "--limit", "memory=100"]
                    .into_iter()
                    .chain(options),
            )
            .fails(5);
        assert!(run.err.contains(&format!("(stage {stage})")), "{}", run.err);
    }
    assert_eq!(f.names(), ["grid.obj"]);
}

#[test]
fn a_folder_as_output_is_made_and_an_existing_one_always_means_inside() {
    let f = Folder::new();
    f.file("a.obj", grid(2));
    f.file("b.part.obj", grid(2));
    f.lodc(["build", "a.obj", "b.part.obj", "-o", "new/deep", "-q"]).ends(0);
    assert!(f.has("new/deep/a.obj.lodc") && f.has("new/deep/b.part.obj.lodc"));
    f.lodc(["build", "a.obj", "-o", "new", "-q"]).ends(0);
    assert!(f.has("new/a.obj.lodc"));
    f.lodc(["build", "a.obj", "-o", "slash/", "-q"]).ends(0);
    assert!(f.has("slash/a.obj.lodc"));
    f.lodc(["build", "a.obj", "-q"]).ends(0);
    assert!(f.has("a.obj.lodc"), "without -o beside the input");
}

#[test]
fn streams_go_in_and_out() {
    let f = Folder::new();
    f.file("a.obj", grid(5));
    f.lodc(["build", "a.obj", "-o", "a.lodc", "-q"]).ends(0);
    let piped = f.lodc_with(["build", "-", "-o", "-", "-q"], grid(5).as_bytes()).ends(0);
    let info = f.lodc_with(["info", "-", "--json"], &piped.out).ends(0).json();
    assert_eq!(info["objects"][0]["triangles"], 50);
    assert_eq!(info["levels_table"][0]["triangles"], 50);
    assert!(info["levels_table"][3]["triangles"].as_u64() <= Some(5), "{info}");
    assert_eq!(info["bounds"][1][0].as_f64(), Some(5.0), "{info}");
    let lists = &info["objects"][0]["collapse_lists"];
    let [mean, longest] = ["mean", "longest"].map(|key| lists[key].as_f64().expect("a number"));
    assert!(1.0 < mean && mean < longest, "{lists}");
    f.lodc_with(["verify", "-"], &piped.out).ends(0);
    let mesh = f
        .lodc_with(
            ["extract", "-", "-o", "-", "--format", "obj", "--triangles", "10", "-q"],
            &piped.out,
        )
        .ends(0);
    assert_eq!(mesh.text().lines().filter(|l| l.starts_with("f ")).count(), 10);
    let glb = f.lodc(["extract", "a.lodc", "-o", "-", "--ratio", "1"]).ends(0);
    assert_eq!(&glb.out[..4], b"glTF");
}

#[test]
fn a_dependency_file_names_every_file_read() {
    let f = Folder::new();
    f.file("my grid.obj", format!("mtllib colours.mtl\nusemtl red\n{}", grid(2)));
    f.file("colours.mtl", "newmtl red\nKd 1 0 0\n");
    f.lodc(["build", "my grid.obj", "-o", "my grid.lodc", "--depfile", "deps.d", "-q"]).ends(0);
    let deps = String::from_utf8(f.read("deps.d")).expect("text");
    assert!(deps.starts_with("my\\ grid.lodc:"), "{deps}");
    assert!(deps.contains("my\\ grid.obj") && deps.contains("colours.mtl"), "{deps}");
}

#[test]
fn several_objects_are_counted_one_by_one_and_together() {
    let f = Folder::new();
    f.file("s.gltf", scene(&[1.0, 2.0, 0.5], 4));
    let report =
        f.lodc(["build", "s.gltf", "-o", "s.lodc", "--report", "json", "-q"]).ends(0).json();
    let one = &report["inputs"][0];
    assert_eq!(one["triangles"], 96);
    assert_eq!(one["objects"].as_array().map(Vec::len), Some(3));
    assert_eq!(one["objects"][1]["name"], "grid1");
}

/// Bars side by side, each longer than the one before, as OBJ.
fn bars(count: u32) -> String {
    let mut obj = String::new();
    for i in 0..count {
        let (length, y) = (0.1 + 0.05 * f64::from(i), f64::from(i));
        for corner in 0..8 {
            let end = |bit: u32, size: f64| if corner & bit == 0 { 0.0 } else { size };
            obj += &format!("v {} {} {}\n", end(4, length), y + end(2, 0.7), end(1, 0.4));
        }
        for side in
            [[1, 2, 4, 3], [5, 7, 8, 6], [1, 5, 6, 2], [3, 4, 8, 7], [1, 3, 7, 5], [2, 6, 8, 4]]
        {
            let [a, b, c, d] = side.map(|corner| 8 * i + corner);
            obj += &format!("f {a} {b} {c} {d}\n");
        }
    }
    obj
}

#[test]
fn what_hybrid_gains_nothing_on_is_left_to_quadric_and_that_is_said() {
    let f = Folder::new();
    f.file("bars.obj", bars(30));
    let says_so = |metric: &str, output: &str| {
        let run = f.lodc(["build", "bars.obj", "-o", output, "--metric", metric]).ends(0);
        run.err.contains("hybrid looks no better than quadric here")
    };
    assert!(says_so("hybrid", "hybrid.lodc"));
    assert!(!says_so("quadric", "quadric.lodc"));
    let level = |metric: &str| {
        let (file, level) = (format!("{metric}.lodc"), format!("{metric}.obj"));
        f.lodc(["extract", &file, "--ratio", "0.5", "-o", &level]).ends(0);
        f.read(&level)
    };
    assert_eq!(level("hybrid"), level("quadric"));
}

#[test]
fn what_has_no_triangles_passes_through_with_a_warning() {
    let f = Folder::new();
    f.file("points.obj", "v 0 0 0\nv 1 1 1\np 1 2\nf 1 1 2\n");
    let run = f.lodc(["build", "points.obj", "-o", "points.lodc"]).ends(0);
    assert!(run.err.contains("warning"), "{}", run.err);
    f.lodc(["verify", "points.lodc"]).ends(0);
    f.lodc(["extract", "points.lodc", "--ratio", "0.5", "-o", "points.ply"]).ends(0);
}

#[test]
fn the_gpu_layout_shows_the_same_levels() {
    let f = Folder::new();
    f.file("grid.obj", grid(12));
    f.lodc(["build", "grid.obj", "-o", "g.lodc", "-q"]).ends(0);
    f.lodc(["build", "grid.obj", "-o", "named.lodc", "--layout", "packed", "-q"]).ends(0);
    assert!(f.read("g.lodc") == f.read("named.lodc"), "packed is what is written anyway");
    f.lodc(["build", "grid.obj", "-o", "w.lodc", "--layout", "gpu", "-q"]).ends(0);
    assert!(f.read("w.lodc").len() > f.read("g.lodc").len());
    for (name, layout) in [("g.lodc", "packed"), ("w.lodc", "gpu")] {
        f.lodc(["verify", name, "--source", "grid.obj"]).ends(0);
        assert_eq!(f.lodc(["info", name, "--json"]).ends(0).json()["layout"], layout);
        assert!(f.lodc(["info", name]).ends(0).text().contains(&format!("{layout} layout")));
        let out = format!("{name}.obj");
        f.lodc(["extract", name, "--triangles", "60", "-o", &out, "-q"]).ends(0);
        let lods = format!("{name}.lods");
        f.lodc(["pack", name, "-o", &lods, "-q"]).ends(0);
    }
    assert!(f.read("g.lodc.obj") == f.read("w.lodc.obj"));
    assert!(f.read("g.lodc.lods") == f.read("w.lodc.lods"));
    let bits = |name: &str, model: &str| {
        let info = f.lodc(["info", name, "--json"]).ends(0).json();
        info["objects"][0]["models"][model]["bits_per_vertex"]["file"].as_f64().expect("a number")
    };
    assert!(bits("g.lodc", "speed") < bits("w.lodc", "speed"));
    // The program's streams become files of either layout; a mesh has none.
    f.lodc(["unpack", "g.lodc.lods", "-o", "again.lodc", "--layout", "gpu", "-q"]).ends(0);
    assert_eq!(f.lodc(["info", "again.lodc", "--json"]).ends(0).json()["layout"], "gpu");
    f.lodc(["unpack", "g.lodc.lods", "-o", "m.obj", "--layout", "gpu"]).ends(2);
    f.lodc(["build", "grid.obj", "--layout", "wide"]).ends(2);
    // Up to date is what was made with the same options.
    let built = ["build", "grid.obj", "-o", "w.lodc", "--if-changed", "--report", "json", "-q"];
    let fresh = |more: &[&str]| {
        let run = f.lodc(built.iter().chain(more)).ends(0).json();
        run["inputs"][0]["up_to_date"].as_bool().expect("a truth")
    };
    assert!(fresh(&["--layout", "gpu"]));
    assert!(!fresh(&[]) && fresh(&[]) && fresh(&["--layout", "packed"]));
}
