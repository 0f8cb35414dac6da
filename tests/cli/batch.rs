//! Many assets in one run: folders, lists, parts, what is up to date, and configurations.

use crate::support::{Folder, Run, asked, grid, scene};
use serde_json::Value;
use std::process::Command;

/// A folder `in` with meshes in two levels and a file that is none.
fn models() -> Folder {
    let f = Folder::new();
    f.file("in/a.obj", grid(4));
    f.file("in/props/b.obj", grid(6));
    f.file("in/props/c.OBJ", grid(3));
    f.file("in/readme.txt", "not a mesh");
    f.file("in/.hidden/d.obj", grid(3));
    f
}

fn lines(run: &Run) -> Vec<Value> {
    let out = String::from_utf8_lossy(&run.out);
    out.lines().map(|line| serde_json::from_str(line).expect("one document a line")).collect()
}

#[test]
fn a_folder_is_mirrored_and_outputs_keep_their_extension() {
    let f = models();
    let run = f.lodc(["build", "in", "-o", "out"]).ends(0);
    assert!(run.err.contains("3 built, 0 up to date, 0 failed"), "{}", run.err);
    for file in ["out/a.obj.lodc", "out/props/b.obj.lodc", "out/props/c.OBJ.lodc"] {
        assert!(f.has(file), "{file}");
    }
    assert!(!f.has("out/.hidden") && !f.has("out/readme.txt.lodc"));
    f.lodc(["build", "in/props", "--exclude", "c.*", "-q"]).ends(0);
    assert!(f.has("in/props/b.obj.lodc") && !f.has("in/props/c.OBJ.lodc"));
    f.lodc(["build", "in", "-o", "some", "--include", "**/b.*", "-q"]).ends(0);
    assert!(f.has("some/props/b.obj.lodc") && !f.has("some/a.obj.lodc"));
    let none = f.lodc(["build", "in", "-o", "none", "--include", "*.xyz"]).fails(3);
    assert!(none.err.contains("in: no file of this folder matches"), "{}", none.err);
    f.lodc(["build", "in", "--include", "a["]).fails(2);
}

#[test]
fn a_run_gives_the_bytes_that_single_builds_give() {
    let f = models();
    f.lodc(["build", "in", "-o", "two", "--jobs", "2", "-q"]).ends(0);
    f.lodc(["build", "in", "-o", "one", "--jobs", "1", "-q"]).ends(0);
    f.lodc(["build", "in/props/b.obj", "-o", "b.lodc", "-q"]).ends(0);
    assert_eq!(f.read("two/a.obj.lodc"), f.read("one/a.obj.lodc"));
    assert_eq!(f.read("two/props/b.obj.lodc"), f.read("b.lodc"));
}

#[test]
fn one_bad_asset_never_stops_the_rest() {
    let f = models();
    f.file("in/bad.obj", "v 0 0 0\nf 1 2 3\n");
    let run = f.lodc(["build", "in", "-o", "out", "--report", "jsonl", "-q"]).ends(3);
    let lines = lines(&run);
    assert_eq!(lines.len(), 5);
    let bad = lines.iter().find(|l| l["input"] == "in/bad.obj").expect("a line for each asset");
    assert_eq!((&bad["status"], &bad["up_to_date"]), (&3.into(), &false.into()));
    assert!(bad["error"].as_str().is_some_and(|e| e.contains("bad.obj")));
    assert!(lines[..4].iter().all(|l| l["seconds"].is_f64() && l["output"].is_string()));
    let summary = serde_json::json!({"summary": {"built": 3, "up_to_date": 0, "failed": 1}});
    assert_eq!(lines[4], summary);
}

#[test]
fn named_inputs_that_share_an_output_are_errors_and_the_others_are_built() {
    let f = models();
    f.file("x/a.obj", grid(3));
    let args = ["build", "in/a.obj", "x/a.obj", "in/props/b.obj", "-o", "out/", "--report", "json"];
    let run = f.lodc(args).ends(2);
    let report = run.json();
    let status: Vec<_> =
        report["inputs"].as_array().expect("inputs").iter().map(|i| i["status"].clone()).collect();
    assert_eq!(status, [2, 2, 0]);
    assert!(!f.has("out/a.obj.lodc") && f.has("out/b.obj.lodc"));
    assert!(run.err.contains("in/a.obj and x/a.obj would both be written there"), "{}", run.err);
}

#[test]
fn a_list_names_inputs_outputs_and_options() {
    let f = models();
    let list = r#"{"input": "in/a.obj", "options": {"models": ["interactive"]}}

{"input": "in/props/b.obj", "output": "sub/b.lodc", "options": {"lock-border": true}}
"#;
    f.file("list.jsonl", list);
    f.lodc(["build", "--manifest", "list.jsonl", "-o", "out", "-q"]).ends(0);
    f.lodc(["build", "in/a.obj", "-o", "a.lodc", "--models", "interactive", "-q"]).ends(0);
    f.lodc(["build", "in/props/b.obj", "-o", "b.lodc", "--lock-border", "-q"]).ends(0);
    assert_eq!(f.read("out/in/a.obj.lodc"), f.read("a.lodc"));
    assert_eq!(f.read("out/sub/b.lodc"), f.read("b.lodc"));

    f.file("wrong.jsonl", "{\"input\": \"in/a.obj\", \"options\": {\"metrik\": \"hybrid\"}}\n");
    let run = f.lodc(["build", "--manifest", "wrong.jsonl", "-o", "out"]).fails(2);
    assert!(run.err.contains("line 1") && run.err.contains("--metric"), "{}", run.err);
    f.file("broken.jsonl", "{\"input\": \"in/a.obj\"}\n{\"inputs\": 1}\n");
    let run = f.lodc(["build", "--manifest", "broken.jsonl"]).fails(3);
    assert!(run.err.contains("broken.jsonl: line 2"), "{}", run.err);
}

#[test]
fn parts_of_a_run_make_up_the_whole() {
    let f = models();
    f.lodc(["build", "in", "-o", "all", "-q"]).ends(0);
    let mut parts = 0;
    for part in ["1/3", "2/3", "3/3"] {
        let run =
            f.lodc(["build", "in", "-o", "parts", "--shard", part, "--report", "jsonl", "-q"]);
        parts += lines(&run.ends(0)).len() - 1;
    }
    assert_eq!(parts, 3, "each asset is in one part");
    for file in ["a.obj.lodc", "props/b.obj.lodc", "props/c.OBJ.lodc"] {
        assert_eq!(f.read(&format!("all/{file}")), f.read(&format!("parts/{file}")));
    }
    f.lodc(["build", "in", "--shard", "0/3"]).ends(2);
}

#[test]
fn what_is_up_to_date_is_not_touched() {
    let f = models();
    f.file("in/m.obj", format!("mtllib m.mtl\n{}", grid(3)));
    f.file("in/m.mtl", "newmtl a\nKd 1 0 0\n");
    let build = ["build", "in", "-o", "out", "--if-changed", "--report", "json", "-q"];
    let counts = |args: &[&str]| f.lodc(args).ends(0).json()["summary"].clone();
    let summary = |built: u32, left: u32| {
        let all = [("built", built), ("up_to_date", left), ("failed", 0)];
        Value::Object(all.map(|(key, n)| (key.to_owned(), n.into())).into_iter().collect())
    };
    assert_eq!(counts(&build), summary(4, 0));
    let modified =
        || f.join("out/a.obj.lodc").metadata().and_then(|m| m.modified()).expect("a time");
    let before = modified();
    assert_eq!(counts(&build), summary(0, 4));
    assert_eq!(modified(), before);
    // Content counts, not times; files that the input names count, too; so do options.
    f.file("in/a.obj", grid(4));
    assert_eq!(counts(&build), summary(0, 4));
    f.file("in/a.obj", grid(5));
    f.file("in/m.mtl", "newmtl a\nKd 0 1 0\n");
    assert_eq!(counts(&build), summary(2, 2));
    let other: Vec<&str> = build.iter().copied().chain(["--lock-border"]).collect();
    assert_eq!(counts(&other), summary(4, 0));
    // So do image files, of which the build itself reads none.
    f.file("in/m.mtl", "newmtl a\nmap_Kd m.png\n");
    f.file("in/m.png", "one");
    assert_eq!(counts(&build), summary(4, 0));
    f.file("in/m.png", "two");
    assert_eq!(counts(&build), summary(1, 3));
    let other = [&build[..], &["--depfile", "d"]].concat();
    assert_eq!(counts(&other), summary(0, 4));
    assert!(String::from_utf8_lossy(&f.read("d")).contains("in/m.png"));
    // A damaged result is made again.
    let mut bytes = f.read("out/a.obj.lodc");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    f.file("out/a.obj.lodc", bytes);
    assert_eq!(counts(&other), summary(1, 3));
}

/// Builds an input if something has changed: its report, the warnings on standard error, the
/// dependency file.
fn rebuilt(f: &Folder, input: &str, more: &[&str]) -> (Value, Vec<String>, String) {
    let args = ["build", input, "-o", "m.lodc", "--if-changed", "--report", "json"];
    let run = f.lodc([&args[..], &["--depfile", "d"], more].concat()).ends(0);
    let warnings = run.err.lines().filter(|l| l.contains("warning")).map(str::to_owned).collect();
    let deps = String::from_utf8_lossy(&f.read("d")).into_owned();
    (run.json()["inputs"][0].clone(), warnings, deps)
}

#[test]
fn a_file_that_was_missing_counts_when_it_comes() {
    let f = Folder::new();
    f.file("in/m.obj", format!("mtllib m.mtl\nusemtl a\n{}", grid(3)));
    let mut gltf: Value = serde_json::from_str(&scene(&[1.0], 2)).expect("sound");
    gltf["images"] = serde_json::json!([{ "uri": "m.png" }]);
    f.file("in/m.gltf", gltf.to_string());
    let hybrid = ["--metric", "hybrid"];
    for (input, more) in [("in/m.obj", &[][..]), ("in/m.obj", &hybrid), ("in/m.gltf", &[])] {
        let is_old = |missing: &[&str]| {
            let (report, _, deps) = rebuilt(&f, input, more);
            for name in missing {
                assert!(deps.contains(&format!("\n{name}:\n")), "{name}: {deps}");
                assert!(deps.contains(&format!("\\\n  {name}")), "{name}: {deps}");
            }
            assert!(missing.len() == deps.matches(":\n").count(), "{deps}");
            report["up_to_date"] == false
        };
        let mut missing = if input == "in/m.obj" { vec!["in/m.mtl"] } else { vec!["in/m.png"] };
        assert!(is_old(&missing) && !is_old(&missing), "{input} {more:?}");
        if input == "in/m.obj" {
            f.file("in/m.mtl", "newmtl a\nmap_Kd m.png\n");
            missing = vec!["in/m.png"];
            assert!(is_old(&missing) && !is_old(&missing), "{input} {more:?}");
        }
        f.file("in/m.png", "no picture, but there");
        assert!(is_old(&[]) && !is_old(&[]), "{input} {more:?}");
        for name in ["in/m.mtl", "in/m.png"].iter().filter(|name| f.has(name)) {
            std::fs::remove_file(f.join(name)).expect("it is there");
        }
        assert!(is_old(&[if input == "in/m.obj" { "in/m.mtl" } else { "in/m.png" }]));
    }
}

#[test]
fn a_library_under_another_spelling_is_not_missed() {
    let f = Folder::new();
    f.file("in/m.obj", format!("mtllib .\\a.mtl b.mtl\n{}", grid(3)));
    for name in ["in/a.mtl", "in/b.mtl"] {
        f.file(name, "newmtl a\n");
    }
    let (_, _, deps) = rebuilt(&f, "in/m.obj", &[]);
    assert!(!deps.contains(":\n") && deps.contains("b.mtl"), "{deps}");
    assert_eq!(rebuilt(&f, "in/m.obj", &[]).0["up_to_date"], true);
}

#[test]
fn no_time_says_what_is_up_to_date() {
    let f = Folder::new();
    f.file("in/m.obj", grid(3));
    let stamp = |seconds: u64| {
        let time = std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds);
        let file = std::fs::File::options().write(true).open(f.join("in/m.obj")).expect("m.obj");
        file.set_modified(time).expect("a time can be set");
    };
    let up_to_date = || rebuilt(&f, "in/m.obj", &[]).0["up_to_date"].clone();
    // A clock that is ahead of this one's.
    stamp(1 << 32);
    assert_eq!([up_to_date(), up_to_date()], [false, true]);
    f.file("in/m.obj", grid(4));
    stamp(1 << 32);
    assert_eq!([up_to_date(), up_to_date()], [false, true]);
    stamp(1 << 30);
    assert_eq!(up_to_date(), true);
}

#[test]
fn warnings_of_the_run_that_built_are_repeated() {
    let f = Folder::new();
    f.file("in/m.obj", format!("mtllib m.mtl\nusemtl a\n{}f 1 1 2\n", grid(3)));
    let (built, said, _) = rebuilt(&f, "in/m.obj", &[]);
    assert!(said.len() >= 2, "{said:?}");
    let (report, again, _) = rebuilt(&f, "in/m.obj", &[]);
    assert_eq!((&built["up_to_date"], &report["up_to_date"]), (&false.into(), &true.into()));
    assert_eq!((&report["warnings"], again), (&built["warnings"], said));
    assert!(report["warnings"].as_array().is_some_and(|all| all.len() >= 2), "{report}");
}

#[test]
fn a_folder_is_verified_against_the_meshes_of_another() {
    let f = models();
    f.lodc(["build", "in", "-o", "out", "-q"]).ends(0);
    let report = f.lodc(["verify", "out", "--source", "in", "--json"]).ends(0).json();
    let files = report["files"].as_array().expect("files");
    assert_eq!(files.len(), 3);
    let compared = |file: &Value| {
        file["checks"].as_array().is_some_and(|all| all.iter().any(|c| c["model"] == "source"))
    };
    assert!(files.iter().all(compared));
    let one = f.lodc(["verify", "out", "--include", "a.*", "--json"]).ends(0).json();
    assert_eq!(one["files"].as_array().map(Vec::len), Some(1));
    f.file("in/a.obj", grid(5));
    let run = f.lodc(["verify", "out", "--source", "in", "-q"]).fails(1);
    assert!(run.err.contains("out/a.obj.lodc: no mesh in in has the content"), "{}", run.err);
    f.lodc(["verify", "in"]).fails(3);
}

#[test]
fn a_configuration_gives_defaults_that_flags_beat() {
    let f = models();
    let configuration = "[defaults]\nmodels = [\"interactive\"]\n\
        [profile.fast]\neffort = \"fast\"\n\
        [[override]]\nfiles = [\"props/**\"]\nlock-border = true\n\
        [override.build]\nmetric = \"kl\"\n";
    f.file("in/lodc.toml", configuration);
    f.lodc(["build", "in", "-o", "out", "-q"]).ends(0);
    let single = |args: &[&str]| {
        f.lodc(["build", "-o", "x.lodc", "-q", "--config", "none.toml"].iter().chain(args)).ends(0);
        f.read("x.lodc")
    };
    f.file("none.toml", "");
    assert_eq!(f.read("out/a.obj.lodc"), single(&["in/a.obj", "--models", "interactive"]));
    let b = ["in/props/b.obj", "--models", "interactive", "--lock-border", "--metric", "kl"];
    assert_eq!(f.read("out/props/b.obj.lodc"), single(&b));
    f.lodc(["build", "in", "-o", "flag", "--metric", "quadric", "-q"]).ends(0);
    assert_eq!(f.read("flag/props/b.obj.lodc"), single(&b[..4]));

    // What one command takes is no mistake for the others, and parts have switches of their own.
    f.file(
        "in/lodc.toml",
        "[defaults]\nmodels = \"none\"\n[[override]]\nmaterials = [\"*\"]\nlock = true\n",
    );
    f.lodc(["build", "in", "-o", "none", "-q"]).ends(0);
    f.file("in/lodc.toml", configuration);

    let shown = f.lodc(["config", "--show", "in/props/b.obj"]).ends(0);
    let shown = String::from_utf8_lossy(&shown.out);
    for part in ["build --metric kl", "--lock-border", "in/lodc.toml [[override]] 1", "[defaults]"]
    {
        assert!(shown.contains(part), "{part} in\n{shown}");
    }
    let run = f.lodc(["build", "in", "-o", "out", "--profile", "slow"]).fails(2);
    assert!(run.err.contains("no profile slow; there are: fast"), "{}", run.err);
    for (wrong, part) in [
        ("[defaults]\nmetrik = \"kl\"", "did you mean `metric`?"),
        (
            "[defaults]\nlock-border = \"yes\"",
            "line 2: [defaults]: lock-border: must be true or false, not \"yes\"",
        ),
        (
            "[defaults]\n\nmetric = \"nothing\"",
            "line 3: [defaults]: metric: must be one of quadric, viewpoint, kl, hybrid, not \
             \"nothing\"",
        ),
        ("[defaults]\nweight = [\"uv=1\", \"uv=x\"]", "line 2: [defaults]: weight: \"uv=x\": "),
        ("[defaults]\nmetric = true", "line 2: [defaults]: metric: needs a value"),
        (
            "[[override]]\nfiles = [\"*\"]\n[[override]]\nfiles = [\"*\"]\n\
             [override.build]\nmetric = 3",
            "line 6: [[override]] 2, [override.build]: metric: must be one of",
        ),
        ("[default]\n", "line 1"),
        (
            "[defaults.extract]\nerror = \"1%\"\nratio = 0.5",
            "line 3: [defaults.extract]: ratio cannot be given with error",
        ),
        (
            "[[override]]\nobjects = [\"x\"]\nlevels = [\"50%\"]\neffort = \"fast\"",
            "line 4: [[override]] 1: effort: unknown field `effort`, expected one of `objects`",
        ),
        (
            "[[override]]\nfile = [\"x\"]",
            "line 2: [[override]] 1: file: unknown option; did you mean `files`?",
        ),
        ("[defaults.extrct]\nratio = 1", "extrct: unknown command; did you mean `extract`?"),
        ("\n[override]\nfiles = [\"x\"]", "line 2: write [[override]] with two brackets"),
        (
            "[[override]]\nfiles = \"props/**\"",
            "line 2: [[override]] 1: files must be a list: [\"props/**\"]",
        ),
        ("[defaults]\nallow-path = \"/\"", "only the command line"),
        ("[defaults]\nshard = \"1/2\"", "for a whole run"),
        ("[[override]]\nfiles = [\"a[\"]", "glob a["),
    ] {
        f.file("in/lodc.toml", wrong);
        let run = f.lodc(["build", "in", "-o", "out"]).fails(2);
        assert!(run.err.contains(part) && run.err.contains("in/lodc.toml"), "{}", run.err);
        assert_eq!(run.err.lines().count(), 1, "once for all assets: {}", run.err);
    }
}

#[test]
fn limits_of_a_configuration_a_list_and_the_command_line_count_key_by_key() {
    let f = Folder::new();
    f.file("a.obj", grid(4));
    f.file("lodc.toml", "[defaults]\nlimit = [\"vertices=3\", \"file=1G\"]\n");
    f.file("raised.jsonl", "{\"input\": \"a.obj\", \"options\": {\"limit\": \"vertices=1M\"}}\n");
    f.file("lowered.jsonl", "{\"input\": \"a.obj\", \"options\": {\"limit\": [\"file=3\"]}}\n");
    for (args, status) in [
        (&["a.obj"][..], 5),
        (&["a.obj", "--limit", "file=2G"], 5),
        (&["a.obj", "--limit", "vertices=1M"], 0),
        (&["a.obj", "--limit", "vertices=1M", "--limit", "file=3"], 5),
        (&["--manifest", "raised.jsonl"], 0),
        (&["--manifest", "raised.jsonl", "--limit", "vertices=3"], 5),
        (&["--manifest", "lowered.jsonl", "--limit", "vertices=1M"], 5),
        (&["--manifest", "lowered.jsonl", "--limit", "vertices=1M", "--limit", "file=1M"], 0),
    ] {
        f.lodc(["build", "-q"].iter().chain(args)).ends(status);
    }
    f.file("lodc.toml", "[defaults]\nlimit-vertices = 3\n");
    let run = f.lodc(["build", "a.obj"]).fails(2);
    assert!(run.err.contains("did you mean `limit`?"), "{}", run.err);
}

#[test]
fn a_configuration_above_the_folder_that_was_given_is_not_read() {
    let f = models();
    f.file("lodc.toml", "[defaults]\nnonsense = 1\n");
    f.lodc(["build", "in", "-o", "out", "-q"]).ends(0);
    f.lodc(["build", "in/a.obj", "-q"]).fails(2);
}

/// What a build tool prints. None if it is not asked for.
fn tool(f: &Folder, name: &str, args: &[&str]) -> Option<String> {
    if !asked(name) {
        return None;
    }
    let run = Command::new(name).args(args).current_dir(f.path()).output();
    let output = run.unwrap_or_else(|e| panic!("{name}: {e}"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[test]
fn make_builds_again_when_a_file_that_the_input_names_changes() {
    let f = Folder::new();
    f.file("m.obj", format!("mtllib m.mtl\n{}", grid(3)));
    f.file("m.mtl", "newmtl a\n");
    let lodc = crate::support::LODC;
    f.file(
        "Makefile",
        format!("m.lodc: m.obj\n\t{lodc} build -q m.obj -o $@ --depfile m.d\n-include m.d\n"),
    );
    let Some(first) = tool(&f, "make", &[]) else { return };
    assert!(first.contains("build"));
    assert!(tool(&f, "make", &[]).is_some_and(|out| out.contains("up to date")));
    let later = std::time::SystemTime::now() + std::time::Duration::from_secs(2);
    let library = std::fs::File::options().write(true).open(f.join("m.mtl")).expect("m.mtl");
    library.set_modified(later).expect("a time can be set");
    assert!(tool(&f, "make", &[]).is_some_and(|out| out.contains("build -q m.obj")));
}

#[test]
fn make_builds_until_a_missing_file_has_come() {
    let f = Folder::new();
    f.file("m.obj", format!("mtllib m.mtl\n{}", grid(3)));
    let build = format!("{} build -q m.obj -o $@ --depfile m.d --if-changed", crate::support::LODC);
    f.file("Makefile", format!("m.lodc: m.obj\n\t{build}\n-include m.d\n"));
    for _ in 0..2 {
        let Some(out) = tool(&f, "make", &[]) else { return };
        assert!(out.contains("build -q m.obj"), "{out}");
    }
    f.file("m.mtl", "newmtl a\n");
    let out = tool(&f, "make", &[]).expect("make is there");
    assert!(out.contains("build -q m.obj"), "{out}");
    assert!(tool(&f, "make", &[]).is_some_and(|out| out.contains("up to date")));
}

#[test]
fn ninja_reads_the_dependency_file() {
    let f = Folder::new();
    f.file("m.obj", format!("mtllib m.mtl\n{}", grid(3)));
    f.file("m.mtl", "newmtl a\n");
    let lodc = crate::support::LODC;
    f.file(
        "build.ninja",
        format!(
            "rule lod\n  command = {lodc} build -q $in -o $out --depfile $out.d\n  \
             depfile = $out.d\n  deps = gcc\nbuild m.lodc: lod m.obj\n"
        ),
    );
    if tool(&f, "ninja", &[]).is_none() {
        return;
    }
    assert!(tool(&f, "ninja", &[]).is_some_and(|out| out.contains("no work to do")));
    let deps = tool(&f, "ninja", &["-t", "deps"]).expect("ninja is there");
    assert!(deps.contains("m.mtl"), "{deps}");
}
