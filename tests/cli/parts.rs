//! Options of objects and materials, from the command line and from configurations.

use crate::support::{Folder, scene};
use serde_json::Value;

/// Two equal grids of `n` by `n` squares, `grid0` and `grid1`, in one scene.
fn folder(n: usize) -> Folder {
    let f = Folder::new();
    f.file("s.gltf", scene(&[1.0, 1.0], n));
    f
}

/// The objects of a build with further arguments, as `info` has them.
fn objects(f: &Folder, more: &[&str]) -> [Value; 2] {
    let args = ["build", "s.gltf", "-o", "s.lodc", "--models", "none", "-q"];
    f.lodc(args.iter().chain(more)).ends(0);
    let mut objects = f.lodc(["info", "s.lodc", "--json"]).ends(0).json()["objects"].take();
    [0, 1].map(|i| {
        objects[i]["name"].take();
        objects[i].take()
    })
}

#[test]
fn an_object_has_a_metric_of_its_own_and_flags_win() {
    let f = folder(4);
    let [plain, same] = objects(&f, &[]);
    assert_eq!(plain, same, "equal grids have equal levels");
    let [by_kl, _] = objects(&f, &["--metric", "kl"]);
    assert_ne!(plain, by_kl);
    let part = r#"{"objects": ["*1"], "metric": "kl"}"#;
    assert_eq!(objects(&f, &["--part", part]), [plain.clone(), by_kl.clone()]);
    f.file("lodc.toml", "[[override]]\nobjects = [\"grid1\"]\nmetric = \"kl\"\n");
    assert_eq!(objects(&f, &[]), [plain.clone(), by_kl]);
    assert_eq!(objects(&f, &["--metric", "quadric"]), [plain.clone(), plain]);
    let shown = f.lodc(["config", "--show", "s.gltf"]).ends(0).text();
    assert!(shown.contains(r#"build --part '{"metric":"kl","objects":["grid1"]}'"#), "{shown}");
    // Parts of a file that has its order of collapses keep what still applies.
    f.lodc(["extract", "s.lodc", "-o", "s.glb", "--ratio", "0.5", "-q"]).ends(0);
    f.lodc(["extract", "s.lodc", "-o", "s.glb", "--ratio", "0.5", "--part", part]).fails(2);
}

#[test]
fn objects_have_levels_of_their_own() {
    let f = folder(10);
    f.file(
        "lodc.toml",
        "[defaults]\nmetric = \"quadric\"\n[defaults.extract]\nratio = \"10%\"\n\
         [defaults.chain]\nlevels = [\"50%\", \"10%\"]\n\
         [[override]]\nobjects = [\"grid1\"]\n[override.extract]\nratio = 0.8\n\
         [override.chain]\nlevels = [\"80%\"]\n",
    );
    let triangles = |more: &[&str]| -> Vec<u64> {
        let args = ["extract", "s.gltf", "-o", "s.glb", "--json", "-q", "--per-object"];
        let report = f.lodc(args.iter().chain(more)).ends(0).json();
        let all = report["objects"].as_array().expect("objects").clone();
        all.iter().map(|o| o["triangles"].as_u64().expect("a count")).collect()
    };
    assert_eq!(triangles(&[]), [20, 160]);
    assert_eq!(triangles(&["--triangles", "50"]), [50, 50], "flags win");
    let chain = f.lodc(["chain", "s.gltf", "-o", "c.glb", "--json", "-q"]).ends(0).json();
    let levels = chain["levels"].as_array().expect("levels");
    let counts: Vec<_> = levels.iter().map(|l| l["triangles"].as_u64()).collect();
    assert_eq!(counts.len(), 2);
    assert!(counts.iter().all(|&n| n > Some(160)), "grid1 keeps 80 %: {counts:?}");
}

#[test]
fn a_part_that_is_none_is_named() {
    let f = folder(4);
    for (table, part) in [
        ("objects = [\"a\"]\nmodels = [\"speed\"]", "models"),
        ("objects = [\"a\"]\nmetrik = \"kl\"", "did you mean `metric`?"),
        ("materials = [\"a\"]\nmetric = \"kl\"", "only lock"),
        ("objects = [\"a\"]\nmetric = \"x\"", "no metric x"),
        ("metric = \"kl\"", "names neither files nor objects nor materials"),
    ] {
        f.file("lodc.toml", format!("[[override]]\n{table}\n"));
        let run = f.lodc(["build", "s.gltf", "-o", "s.lodc"]).fails(2);
        assert!(run.err.contains(part) && run.err.contains("[[override]] 1"), "{}", run.err);
    }
}
