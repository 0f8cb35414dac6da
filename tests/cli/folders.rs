//! Folders of assets for `lodc extract` and `lodc chain`, with configurations.

use crate::support::{Folder, Run, grid, scene};
use serde_json::{Value, json};

/// A folder `in` with meshes, a `.lodc` file, and a file that cannot be read.
fn assets() -> Folder {
    let f = Folder::new();
    f.file("in/a.obj", grid(6));
    f.file("in/props/b.obj", grid(8));
    f.lodc(["build", "in/props/b.obj", "-o", "in/props/b.lodc", "-q"]).ends(0);
    f.file("in/bad.obj", "v 0 0 0\nf 1 2 3\n");
    f.file("in/readme.txt", "not a mesh");
    f
}

fn results(report: &Value) -> Vec<(&str, u64)> {
    let all = report["results"].as_array().expect("a list").iter();
    let status = |r: &Value| if r["error"].is_string() { r["status"].as_u64() } else { Some(0) };
    all.map(|r| (r["input"].as_str().expect("an input"), status(r).expect("a status"))).collect()
}

#[test]
fn a_folder_is_extracted_as_a_mirrored_tree() {
    let f = assets();
    let args = ["extract", "in", "-o", "out", "--ratio", "50%", "--json", "--depfile", "d"];
    let run = f.lodc(args).ends(3);
    let report = run.json();
    let wanted =
        [("in/a.obj", 0), ("in/bad.obj", 3), ("in/props/b.lodc", 0), ("in/props/b.obj", 0)];
    assert_eq!(results(&report), wanted);
    assert!(run.err.contains("3 done, 1 failed"), "{}", run.err);
    assert!(f.has("out/a.obj.glb") && !f.has("out/bad.obj.glb"));
    assert_eq!(f.read_binary("out/props/b.obj.glb"), f.read_binary("out/props/b.lodc.glb"));
    f.lodc(["extract", "in/a.obj", "-o", "a.glb", "--ratio", "50%", "-q"]).ends(0);
    assert_eq!(f.read("out/a.obj.glb"), f.read("a.glb"), "as by itself");
    let rules = String::from_utf8(f.read("d")).expect("text");
    assert_eq!(rules.matches("out/").count(), 3, "{rules}");

    let args = ["extract", "in", "-o", "some", "--ratio", "1", "--format", "obj", "-q"];
    f.lodc(args.iter().chain(&["--include", "**/*.lodc"])).ends(0);
    assert!(f.has("some/props/b.lodc.obj") && !f.has("some/a.obj.obj"));
    f.lodc(["extract", "in", "-o", "-", "--ratio", "1"]).ends(2);
}

#[test]
fn a_folder_becomes_chains() {
    let f = assets();
    let args = ["chain", "in", "-o", "out", "--exclude", "bad.*", "--json"];
    let run = f.lodc(args).ends(0);
    let report = run.json();
    assert_eq!(results(&report).len(), 3);
    let path = &report["results"][0]["outputs"][0]["path"];
    assert_eq!(path, "out/a.obj.glb");
    assert_eq!(report["results"][0]["levels"].as_array().map(Vec::len), Some(4));
    f.lodc(["chain", "in/a.obj", "-o", "a.glb", "-q"]).ends(0);
    assert_eq!(f.read("out/a.obj.glb"), f.read("a.glb"), "as by itself");
    let args = ["chain", "in", "-o", "files", "--separate", "--format", "obj", "--include", "a.*"];
    let run = f.lodc(args).ends(0);
    assert!(f.has("files/a.obj_LOD0.obj") && f.has("files/a.obj_LOD3.obj"), "{}", run.err);
    assert!(run.out.is_empty(), "the table is of a single asset");
    f.lodc(["chain", "in", "-o", "x", "--format", "obj"]).ends(2);
    assert!(f.lodc(["chain", "in", "-o", "out"]).ends(3).err.contains("3 done, 1 failed"));
}

#[test]
fn assets_of_one_run_have_levels_of_their_own() {
    let f = assets();
    f.file(
        "in/lodc.toml",
        "[defaults]\nmetric = \"quadric\"\nweight = \"uv=2\"\n\
         [defaults.chain]\nlevels = [\"50%\", \"25%\"]\n\
         [[override]]\nfiles = [\"props/*\"]\n[override.chain]\nlevels = [\"10%\"]\n",
    );
    let levels = |more: &[&str]| -> Vec<usize> {
        let args = ["chain", "in", "-o", "out", "--exclude", "bad.*", "--json", "-q"];
        let report = f.lodc(args.iter().chain(more)).ends(0).json();
        let all = report["results"].as_array().expect("a list").clone();
        all.iter().map(|r| r["levels"].as_array().map_or(0, Vec::len)).collect()
    };
    assert_eq!(levels(&[]), [2, 1, 1]);
    assert_eq!(levels(&["--levels", "50%"]), [1, 1, 1], "flags win");
    assert_eq!(levels(&["--auto", "3"]), [3, 3, 3], "also those that exclude the option");
    f.file("list.jsonl", r#"{"input": "in/a.obj", "output": "x.glb", "options": {"auto": 2}}"#);
    f.lodc(["chain", "--manifest", "list.jsonl", "-o", "listed", "-q"]).ends(0);
    assert!(f.has("listed/x.glb"));
    let shown = f.lodc(["config", "--show", "in/props/b.obj"]).ends(0).text();
    assert!(shown.contains("chain --levels 10%"), "{shown}");
}

/// A folder `in` of meshes and a folder `out` of files built from them.
fn built() -> Folder {
    let f = Folder::new();
    f.file("in/a.obj", grid(6));
    f.file("in/props/b.obj", grid(8));
    f.lodc(["build", "in", "-o", "out", "-q"]).ends(0);
    f
}

/// Comparisons that take no time.
const QUICK: [&str; 4] = ["--samples", "2000", "--views", "0"];

#[test]
fn a_list_says_what_is_compared_with_what_and_parts_of_it_are_complete() {
    let f = assets();
    let lines = [
        r#"{"a": "in/a.obj", "input": "in/props/b.obj"}"#,
        r#"{"a": "in/a.obj", "input": "in/a.obj", "options": {"ratio": "50%"}}"#,
        r#"{"a": "in/gone.obj", "input": "in/props/b.lodc"}"#,
        r#"{"a": "in/a.obj", "input": "in/bad.obj"}"#,
    ];
    f.file("list", lines.join("\n"));
    let run = |more: &[&str]| {
        f.lodc(["compare", "--manifest", "list", "--json"].iter().chain(&QUICK).chain(more))
    };
    let whole = run(&[]).ends(3).json();
    let of = |report: &Value, i: usize| report["results"][i].clone();
    let half = of(&whole, 1);
    let single = f
        .lodc(["compare", "in/a.obj", "in/a.obj", "--ratio", "50%", "--json"].iter().chain(&QUICK));
    let single = single.ends(0).json();
    assert_eq!(half["rms"], single["rms"], "as by itself");
    assert!(half["triangles"]["b"].as_u64() < half["triangles"]["a"].as_u64());
    let failed: Vec<bool> = (0..4).map(|i| of(&whole, i)["error"].is_string()).collect();
    assert_eq!(failed, [false, false, true, true]);

    let mut parts = Vec::new();
    for part in ["1/2", "2/2"] {
        let report = run(&["--shard", part]).json();
        parts.extend(report["results"].as_array().expect("a list").clone());
    }
    let sorted = |list: &[Value]| {
        let mut names: Vec<String> = list.iter().map(|r| r["input"].to_string()).collect();
        names.sort();
        names
    };
    assert_eq!(sorted(&parts), sorted(whole["results"].as_array().expect("a list")));

    for (line, why) in [
        (r#"{"input": "in/a.obj"}"#, "line 1: a, what to compare with"),
        (r#"{"a": "in/a.obj", "input": "in/a.obj", "output": "x"}"#, "line 1: output"),
        (r#"{"b": "in/a.obj", "input": "in/a.obj"}"#, "line 1"),
    ] {
        f.file("list", line);
        let refused = run(&[]).ends(3);
        assert!(refused.err.contains(why), "{line}: {}", refused.err);
    }
    f.file("list", lines[0]);
    let refused = f.lodc(["build", "--manifest", "list"]).ends(3);
    assert!(refused.err.contains("a is for compare alone"), "{}", refused.err);
    f.lodc(["compare", "in", "out", "--manifest", "list"]).ends(2);
    f.lodc(["compare", "in/a.obj"]).ends(2);
}

#[test]
fn folders_are_compared_file_by_file_and_level_by_level() {
    let f = built();
    f.file("out/c.obj", grid(3));
    let compare = |more: &[&str], status: i32| {
        let args = ["compare", "in", "out", "--levels", "25%,5%", "--json"];
        f.lodc(args.iter().chain(&QUICK).chain(more)).ends(status)
    };
    let run = compare(&[], 3);
    let report = run.json();
    let wanted = [("out/a.obj.lodc", 0), ("out/c.obj", 3), ("out/props/b.obj.lodc", 0)];
    assert_eq!(results(&report), wanted);
    assert!(run.err.contains("out/c.obj: in has no file of this name"), "{}", run.err);
    let first = &report["results"][0];
    assert_eq!((&first["a"], &first["ok"]), (&"in/a.obj".into(), &true.into()));
    let levels = first["levels"].as_array().expect("levels");
    let triangles: Vec<_> = levels.iter().map(|l| l["triangles"]["b"].as_u64()).collect();
    assert_eq!(triangles, [Some(18), Some(3)]);
    let single = ["compare", "in/a.obj", "out/a.obj.lodc", "--ratio", "5%", "--json"];
    let single = f.lodc(single.iter().chain(&QUICK)).ends(0).json();
    assert_eq!(single["hausdorff"], levels[1]["hausdorff"], "as by itself");

    let limit = single["hausdorff"]["max"].as_f64().expect("a distance") * 0.99;
    let limit = ["--max-hausdorff", &limit.to_string(), "--exclude", "c.*", "--junit", "c.xml"];
    let run = compare(&[&limit[..], &["--annotate", "github"]].concat(), 1);
    let report = run.json();
    assert_eq!(report["results"][0]["exceeded"].as_array().map(Vec::len), Some(1), "{report}");
    assert!(run.err.contains("::error file=in/a.obj,title=lodc compare::out/a.obj.lodc at 5%25"));
    let xml = String::from_utf8(f.read("c.xml")).expect("text");
    assert!(xml.contains("classname=\"in/a.obj\" name=\"out/a.obj.lodc at 5%\"><failure"), "{xml}");
    let text = f.lodc(["compare", "in", "out", "--include", "a.*"].iter().chain(&QUICK)).ends(0);
    assert!(
        text.text().starts_with("out/a.obj.lodc: 72 triangles, rms 0.0000 %"),
        "{}",
        text.text()
    );
    let quiet = f.lodc(["compare", "in", "out", "-q", "--exclude", "c.*"].iter().chain(&QUICK));
    assert!(quiet.ends(0).text().is_empty(), "nothing exceeds a limit");
    f.lodc(["compare", "in", "out/a.obj.lodc"]).ends(2);
    f.lodc(["compare", "in", "out", "--heatmap", "x.png"]).ends(2);
}

#[test]
fn a_level_that_got_worse_since_the_last_time_fails() {
    let f = built();
    for baseline in ["base.json", "base/"] {
        let compare = |more: &[&str], status: i32| {
            let args = ["compare", "in", "out", "--levels", "25%,5%", "--baseline", baseline];
            f.lodc(args.iter().chain(&QUICK).chain(more)).ends(status)
        };
        let run = compare(&[], 3);
        assert!(run.err.contains("record one with --record"), "{}", run.err);
        compare(&["--record"], 0);
        compare(&[], 0);
        // Another order of collapses has other distances.
        let good = f.read("out/props/b.obj.lodc");
        f.lodc(["build", "in/props/b.obj", "-o", "out/props/b.obj.lodc", "--metric", "kl", "-q"])
            .ends(0);
        let run = compare(&["--json"], 1);
        let report = run.json();
        assert_eq!(results(&report).len(), 2);
        assert_eq!(report["results"][0]["ok"], true);
        let worse = report["results"][1]["exceeded"].to_string();
        assert!(worse.contains("is worse than") && worse.contains("of the baseline"), "{worse}");
        assert!(report["results"][1]["levels"][0]["baseline"]["rms"].is_f64(), "{report}");
        // Numbers of other options are no comparison, and recording again settles it.
        assert!(compare(&["--seed", "2"], 2).err.contains("record it again"));
        compare(&["--record", "--include", "props/*"], 0);
        compare(&[], 0);
        f.file("out/props/b.obj.lodc", good);
    }
    // Half of what was: twice as far now.
    let file = "base/props/b.obj.lodc.json";
    let args = ["compare", "in", "out", "--levels", "5%", "--baseline", "base"];
    f.lodc(args.iter().chain(&QUICK).chain(&["--record"])).ends(0);
    let mut recorded: Value = serde_json::from_slice(&f.read(file)).expect("a document");
    let far = &mut recorded["levels"]["5%"]["hausdorff"];
    *far = (far.as_f64().expect("a distance") / 2.0).into();
    f.file(file, recorded.to_string());
    for (tolerance, status) in [("2%", 1), ("90%", 1), ("110%", 0), ("1.1", 0)] {
        f.lodc(args.iter().chain(&QUICK).chain(&["--tolerance", tolerance])).ends(status);
    }
    f.file("base.json", "{}");
    let run = f.lodc(["compare", "in", "out", "--baseline", "base.json"]).fails(3);
    assert!(run.err.contains("not a baseline"), "{}", run.err);
    f.lodc(["compare", "in", "out", "--record"]).ends(2);
}

#[test]
fn a_run_over_a_folder_tells_ci_what_failed_and_what_no_input_matched() {
    let f = assets();
    f.file("in/lodc.toml", "[[override]]\nfiles = [\"nothing/*\"]\nmetric = \"hybrid\"\n");
    let run = f.lodc(["build", "in", "-o", "out", "--junit", "r.xml"]).ends(3);
    assert!(run.err.contains("[[override]] 1: no input matches nothing/*"), "{}", run.err);
    let xml = String::from_utf8(f.read("r.xml")).expect("text");
    assert!(
        xml.contains("<testsuites name=\"lodc build\" tests=\"3\" failures=\"0\" errors=\"1\""),
        "{xml}"
    );
    assert!(xml.contains("name=\"build\"><error message="), "{xml}");
    // A named file is nobody else's.
    assert!(
        !f.lodc(["build", "in/a.obj", "-o", "a.lodc"]).ends(0).err.contains("no input matches")
    );
    f.lodc(["build", "in/a.obj", "-o", "a.lodc", "--junit", "in/a.obj"]).ends(2);
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_out_of_a_folder_is_refused_like_a_path_that_does() {
    let f = Folder::new();
    f.file("in/a.obj", grid(3));
    f.file("elsewhere/b.obj", grid(3));
    for (to, link) in [("../elsewhere/b.obj", "in/b.obj"), ("a.obj", "in/c.obj")] {
        std::os::unix::fs::symlink(to, f.join(link)).expect("a link");
    }
    let run = f.lodc(["build", "in", "-o", "out"]).ends(3);
    assert!(
        run.errors() == 1 && run.err.contains("in/b.obj: a link that leads out"),
        "{}",
        run.err
    );
    assert!(f.has("out/a.obj.lodc") && f.has("out/c.obj.lodc") && !f.has("out/b.obj.lodc"));
    f.lodc(["build", "in", "-o", "out", "--allow-path", "elsewhere", "-q"]).ends(0);
    assert!(f.has("out/b.obj.lodc"));
}

#[test]
fn what_a_build_needs_is_told_without_building() {
    let f = assets();
    let args = ["build", "in", "-o", "out", "--estimate", "--report", "json", "-q"];
    let report = f.lodc(args).ends(0).json();
    let inputs = report["inputs"].as_array().expect("inputs");
    assert!(!f.has("out"), "nothing is built");
    for input in inputs {
        let name = input["input"].as_str().expect("a name");
        let counted = input["triangles"].as_u64();
        if name.ends_with("a.obj") {
            f.lodc(["build", name, "-o", "a.lodc", "-q"]).ends(0);
            let built = f.lodc(["info", "a.lodc", "--json"]).ends(0).json();
            assert_eq!(counted, built["objects"][0]["triangles"].as_u64());
        }
        // The program alone takes more than 32 MiB.
        assert!(input["memory"].as_u64() > Some(32 << 20), "{input}");
        assert_eq!(input["status"], 0);
    }
    assert!(f.lodc(["build", "in", "--estimate"]).ends(0).text().contains("of memory"));
    f.lodc(["build", "gone.obj", "--estimate"]).ends(3);
    f.lodc(["build", "-", "--estimate"]).ends(2);
}

/// The numbers of the last line of a report in lines.
fn summary(run: &Run) -> Value {
    let out = String::from_utf8_lossy(&run.out);
    let last = out.lines().last().expect("a line");
    serde_json::from_str::<Value>(last).expect("JSON")["summary"].clone()
}

#[test]
fn every_command_over_folders_leaves_alone_what_is_up_to_date() {
    let f = Folder::new();
    f.file("in/m.gltf", scene(&[1.0, 2.0], 6));
    f.file("in/props/b.obj", grid(6));
    let more = ["--if-changed", "--report", "jsonl", "--depfile", "d", "--junit", "j.xml", "-q"];
    let run = |args: &[&str]| f.lodc(args.iter().chain(&more)).ends(0);
    let times = |names: &[&str]| -> Vec<_> {
        let time =
            |name: &&str| f.join(name).metadata().and_then(|m| m.modified()).expect("a time");
        names.iter().map(time).collect()
    };
    let commands: [(&[&str], &[&str], &str); 5] = [
        (&["build", "in", "-o", "out"], &["out/m.gltf.lodc", "out/props/b.obj.lodc"], "built"),
        (&["chain", "in", "-o", "lv", "--format", "gltf"], &["lv/m.gltf.gltf"], "built"),
        (&["extract", "out", "-o", "ex", "--ratio", "50%", "--format", "stl"], &[], "built"),
        (&["pack", "out", "-o", "st"], &["st/m.gltf.lods", "st/props/b.obj.lods"], "built"),
        (&["verify", "out", "--source", "in"], &[], "verified"),
    ];
    for (args, made, key) in commands {
        let first = run(args);
        assert_eq!(summary(&first), json!({key: 2, "up_to_date": 0, "failed": 0}), "{args:?}");
        let (before, rules) = (times(made), f.read("d"));
        let again = run(args);
        assert_eq!(summary(&again), json!({key: 0, "up_to_date": 2, "failed": 0}), "{args:?}");
        assert_eq!((times(made), f.read("d")), (before, rules), "{args:?}");
        let xml = String::from_utf8(f.read("j.xml")).expect("text");
        assert!(
            xml.contains(&format!("name=\"lodc {}\" tests=\"2\" failures=\"0\"", args[0])),
            "{xml}"
        );
    }
    // Options count, and every file of a result has to be there.
    let other = ["chain", "in", "-o", "lv", "--format", "gltf", "--levels", "50%"];
    assert_eq!(summary(&run(&other))["built"], 2);
    std::fs::remove_file(f.join("lv/m.gltf.bin")).expect("it was written");
    assert_eq!(summary(&run(&other)), json!({"built": 1, "up_to_date": 1, "failed": 0}));
    // So does what an input is made of, and what it is compared with.
    f.file("in/props/b.obj", grid(7));
    assert_eq!(summary(&run(&other)), json!({"built": 1, "up_to_date": 1, "failed": 0}));
    f.lodc(["build", "in", "-o", "out", "-q"]).ends(0);
    for args in [&["verify", "out", "--source", "in"][..], &["pack", "out", "-o", "st"]] {
        assert_eq!(summary(&run(args))["up_to_date"], 1, "{args:?}");
    }
    // Standard output has no record, and verify no result but the JUnit file.
    let level = ["extract", "in/props/b.obj", "--lod", "0", "--if-changed", "-q", "-o"];
    let out = f.lodc(level.iter().chain(&["-"])).ends(0).out;
    f.lodc(level.iter().chain(&["b.glb"])).ends(0);
    assert_eq!(f.read("b.glb"), out);
    f.lodc(["verify", "out", "--depfile", "d"]).ends(2);
}

#[test]
fn results_without_an_input_are_named_and_pruned() {
    let f = Folder::new();
    f.file("in/a.obj", grid(4));
    f.file("in/props/b.obj", grid(5));
    let commands: [&[&str]; 4] = [
        &["build", "in", "-o", "out"],
        &["chain", "in", "-o", "lv", "--separate", "--format", "gltf", "--if-changed"],
        &["extract", "in", "-o", "ex", "--lod", "0", "--format", "obj", "--if-changed"],
        &["pack", "out", "-o", "st", "--if-changed", "--exclude", "c.*"],
    ];
    commands.iter().for_each(|args| drop(f.lodc(*args).ends(0)));
    let foreign = ["out/c.obj.lodc", "lv/c.obj.gltf", "ex/props/b.obj.txt"];
    foreign.iter().for_each(|name| drop(f.file(name, "not by lodc")));
    std::fs::remove_file(f.join("in/props/b.obj")).expect("it is there");
    let all = ["out/props/b.obj.lodc", "lv/props/b.obj_LOD1.bin", "ex/props/b.obj.obj"];
    for (args, gone) in commands.iter().zip(all.into_iter().chain(["st/props/b.obj.lods"])) {
        let run = f.lodc(*args).ends(0);
        let what = "has no input any more: --prune removes it";
        assert!(run.err.contains(what), "{args:?}: {}", run.err);
        assert!(f.has(gone), "{gone}");
        let run = f.lodc(args.iter().chain(&["--prune"])).ends(0);
        assert!(run.err.contains("removed, its input is gone"), "{args:?}: {}", run.err);
        assert!(!f.has(gone), "{gone}");
        assert!(!f.lodc(*args).ends(0).err.contains("no input any more"), "{args:?}");
    }
    assert!(foreign.iter().all(|name| f.has(name)));
    assert!(f.has("out/a.obj.lodc") && f.has("lv/a.obj_LOD0.gltf") && f.has("st/a.obj.lods"));
}

#[test]
fn results_of_named_files_and_lists_are_no_orphans() {
    const NAMES: [&str; 3] = ["a.obj", "b.obj", "elsewhere/c.obj"];
    let f = Folder::new();
    f.file("in/a.obj", grid(4));
    f.file("b.obj", grid(5));
    f.file("elsewhere/c.obj", grid(3));
    f.file("list.jsonl", r#"{"input": "elsewhere/c.obj"}"#);
    let more = ["--manifest", "list.jsonl", "-o", "out", "--prune"];
    let made = |name: &str, extension: &str| {
        assert!(f.has(&format!("out/{name}.{extension}")), "{name}.{extension}");
    };
    for shard in [&[][..], &["--shard", "1/2"], &["--shard", "2/2"]] {
        let run = f.lodc(["build", "in", "b.obj"].iter().chain(&more).chain(shard)).ends(0);
        assert!(!run.err.contains("removed"), "{}", run.err);
        NAMES.iter().for_each(|name| made(name, "lodc"));
    }
    let level = ["--lod", "0", "--format", "obj", "--if-changed"];
    f.lodc(["extract", "in", "b.obj"].iter().chain(&more).chain(&level)).ends(0);
    NAMES.iter().for_each(|name| made(name, "obj"));
}

#[test]
fn a_record_removes_nothing_but_results_beside_it() {
    let f = Folder::new();
    f.file("in/a.obj", grid(3));
    f.file("in/b.obj", grid(4));
    let extract = ["extract", "in", "-o", "ex", "--lod", "0", "--format", "obj", "--if-changed"];
    f.lodc(extract).ends(0);
    f.file("ex/b.obj/note", "a folder of somebody's");
    f.file("keep.txt", "none of lodc's");
    let record = String::from_utf8(f.read("ex/.lodc/b.obj.obj.json")).expect("text");
    assert!(record.contains("\"b.obj.obj\""), "{record}");
    let forged = record.replace("\"b.obj.obj\"", "\"b.obj/../../keep.txt\"");
    f.file("ex/.lodc/b.obj.obj.json", forged);
    std::fs::remove_file(f.join("in/b.obj")).expect("it is there");
    f.lodc(extract.iter().chain(&["--prune"])).ends(0);
    assert!(f.has("keep.txt") && f.has("ex/b.obj.obj") && !f.has("ex/.lodc/b.obj.obj.json"));
}

#[test]
fn a_result_has_one_name_alone_and_in_a_folder() {
    let f = Folder::new();
    f.file("in/club.obj", grid(3));
    for args in [&["build"][..], &["extract", "--lod", "0"], &["chain"]] {
        for (input, out) in [("in", "of a folder/"), ("in/club.obj", "alone/")] {
            f.lodc(args.iter().chain(&[input, "-o", out, "-q"])).ends(0);
        }
    }
    f.lodc(["build", "in/club.obj", "-q"]).ends(0);
    let names = |folder: &str| {
        let files = std::fs::read_dir(f.join(folder)).expect("a folder");
        let name = |e: std::io::Result<std::fs::DirEntry>| e.expect("a file").file_name();
        let mut names: Vec<_> = files.map(name).collect();
        names.sort();
        names
    };
    assert_eq!(names("alone"), ["club.obj.glb", "club.obj.lodc"]);
    assert_eq!(names("alone"), names("of a folder"));
    assert_eq!(names("in"), ["club.obj", "club.obj.lodc"]);
    let run = f.lodc(["build", "in", "-o", "x.lodc"]).fails(2);
    assert!(
        run.err.contains("x.lodc: a file's name, and there are several results"),
        "{}",
        run.err
    );
}
