//! Folders of assets for `lodc extract` and `lodc chain`, with configurations.

use crate::support::{Folder, grid};
use serde_json::Value;

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
    assert_eq!(f.read("out/props/b.obj.glb"), f.read("out/props/b.lodc.glb"));
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
        "[defaults]\nweight = \"uv=2\"\n[defaults.chain]\nlevels = [\"50%\", \"25%\"]\n\
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
