//! `--poses`: errors that hold in the poses of an animated object, too.

use crate::support::Folder;

/// A sphere with two morph targets, which is stretched by them.
fn folder() -> Folder {
    let f = Folder::new();
    let fixture = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/morphing_sphere.glb");
    f.file("m.glb", std::fs::read(fixture).expect("a fixture"));
    f
}

#[test]
fn errors_are_over_rest_and_poses_unless_rest_alone_is_asked_for() {
    let f = folder();
    f.lodc(["build", "m.glb", "-o", "m.lodc", "-q", "--models", "none"]).ends(0);
    let rest = ["build", "m.glb", "-o", "rest.lodc", "-q", "--models", "none", "--poses", "0"];
    f.lodc(rest).ends(0);
    let object = |name: &str| f.lodc(["info", name, "--json"]).ends(0).json()["objects"][0].take();
    let (all, rest) = (object("m.lodc"), object("rest.lodc"));
    assert_eq!(all["errors_over"].to_string(), r#"{"poses":2,"rest":true}"#);
    assert_eq!(rest["errors_over"].to_string(), r#"{"poses":0,"rest":true}"#);
    let error = |object: &serde_json::Value| object["lods"][1]["error"].as_f64();
    assert!(error(&all) > error(&rest), "{all} {rest}");
    assert!(f.lodc(["info", "m.lodc"]).ends(0).text().contains("errors over rest and 2 poses"));
    assert!(!f.lodc(["info", "rest.lodc"]).ends(0).text().contains("errors over"));
    // Both are as far from the truth as they say.
    for file in ["m.lodc", "rest.lodc"] {
        f.lodc(["verify", file, "-q"]).ends(0);
    }
}

#[test]
fn levels_of_a_mesh_and_of_its_file_are_measured_over_the_same_poses() {
    let f = folder();
    f.lodc(["build", "m.glb", "-o", "m.lodc", "-q", "--models", "none"]).ends(0);
    let level = |input: &str, more: &[&str]| {
        let args = ["extract", input, "-o", "l.glb", "--ratio", "0.3", "--no-refit", "--json"];
        f.lodc(args.iter().chain(more)).ends(0).json()
    };
    let (of_file, of_mesh) = (level("m.lodc", &[]), level("m.glb", &["--metric", "quadric"]));
    assert_eq!(of_file["errors_over"]["poses"], 2);
    let error = |report: &serde_json::Value| report["error"].as_f64().expect("a number");
    // That of one level by itself may be tighter; its bound is at most 2 % above the distance.
    assert!(error(&of_mesh) <= 1.02 * error(&of_file));
    assert!(error(&of_mesh) >= 0.8 * error(&of_file));
    let rest = level("m.glb", &["--metric", "quadric", "--poses", "0"]);
    assert_eq!(rest["errors_over"]["poses"], 0);
    assert!(rest["error"].as_f64() < of_mesh["error"].as_f64());
    let chain = ["chain", "m.lodc", "-o", "c.glb", "--levels", "50%,20%", "--json"];
    let chain = f.lodc(chain).ends(0).json();
    assert_eq!(chain["errors_over"]["poses"], 2);
}

#[test]
fn another_number_of_poses_makes_the_file_anew() {
    let f = folder();
    let build = |more: &[&str]| {
        let args = ["build", "m.glb", "-o", "m.lodc", "--if-changed", "--report", "json"];
        let run = f.lodc(args.iter().chain(more)).ends(0);
        run.json()["inputs"][0]["up_to_date"].as_bool()
    };
    assert_eq!(build(&[]), Some(false));
    assert_eq!(build(&[]), Some(true));
    assert_eq!(build(&["--poses", "1"]), Some(false));
    assert_eq!(build(&["--poses", "1"]), Some(true));
    f.file("lodc.toml", "[defaults]\nposes = 0\n");
    assert_eq!(build(&[]), Some(false));
    f.lodc(["build", "m.glb", "--poses", "65"]).ends(2);
}
