//! Misuse that is refused before any work, and the help for it.

use crate::support::{Folder, grid};

#[test]
fn wrong_usage_ends_with_2_and_a_hint() {
    let f = Folder::new();
    f.file("a.obj", grid(2));
    for args in [
        vec!["biuld", "a.obj"],
        vec!["build"],
        vec!["build", "a.obj", "--jbos", "2"],
        vec!["build", "a.obj", "--jobs", "0"],
        vec!["build", "a.obj", "--jobs", "many"],
        vec!["build", "a.obj", "--weld", "2"],
        vec!["build", "a.obj", "-q", "-v"],
        vec!["build", "a.obj", "--models", "speeed"],
        vec!["build", "a.obj", "--models", "none,speed"],
        vec!["extract", "a.lodc", "-o", "b.obj"],
        vec!["extract", "a.lodc", "-o", "b.obj", "--lod", "1", "--ratio", "0.5"],
        vec!["extract", "a.lodc", "-o", "b.obj", "--ratio", "50"],
        vec!["extract", "a.lodc", "-o", "b.obj", "--error", "-1"],
        vec!["verify"],
        vec!["man", "biuld"],
        vec![],
    ] {
        let run = f.lodc(&args).ends(2);
        assert!(!run.err.is_empty(), "{args:?}");
        assert!(!run.err.contains("panicked"), "{args:?}");
    }
    assert!(f.lodc(["biuld"]).err.contains("'build'"), "a typo is answered with the right name");
    assert_eq!(f.names(), ["a.obj"]);
}

#[test]
fn a_wrong_value_is_told_what_it_must_be() {
    let f = Folder::new();
    f.file("a.obj", grid(2));
    for (command, option, value, why) in [
        ("extract", "--error", "0.5mm", "must be a number, such as 0.5, or a percentage"),
        ("extract", "--ratio", "-0.5", "must be a share from 0 to 1"),
        ("extract", "--triangles", "10G", "must be a count: 500, 10k, 2m"),
        ("build", "--weld", "5%", "must be a number from 0 to below 1"),
        ("build", "--jobs", "0", "must be at least 1"),
        ("build", "--jobs", "1.5", "must be a whole number"),
        ("build", "--poses", "99", "must be from 0 to 64"),
    ] {
        let run = f.lodc([command, "a.obj", "-o", "b", option, value]).fails(2);
        assert!(run.err.contains(&format!("'{option} <")) && run.err.contains(why), "{}", run.err);
    }
}

#[test]
fn every_model_and_option_of_the_manual_is_taken() {
    let f = Folder::new();
    f.file("a.obj", grid(2));
    for models in ["speed", "masking", "interactive", "interactive,speed", "none", "all"] {
        f.lodc(["build", "a.obj", "--models", models]).ends(0);
    }
    f.lodc([
        "build",
        "a.obj",
        "--models",
        "interactive",
        "--metric",
        "quadric",
        "--strips",
        "cache",
        "--effort",
        "fast",
    ])
    .ends(0);
}

#[test]
fn help_version_completions_and_manual_pages_go_to_standard_output() {
    let f = Folder::new();
    for args in [
        vec!["--version"],
        vec!["--help"],
        vec!["build", "--help"],
        vec!["completions", "bash"],
        vec!["completions", "zsh"],
        vec!["man"],
        vec!["man", "build"],
    ] {
        let run = f.lodc(&args).ends(0);
        assert!(run.err.is_empty() && !run.out.is_empty(), "{args:?}");
    }
    assert_eq!(f.lodc(["--version"]).text().trim(), concat!("lodc ", env!("CARGO_PKG_VERSION")));
    let page = f.lodc(["man", "extract"]).text();
    for part in ["\\-\\-triangles", "Height of the screen", "[default: 60]", "Print the version"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(f.lodc(["completions", "fish"]).text().contains("extract"));
}

#[test]
fn two_results_of_one_name_or_on_one_stream_are_refused() {
    let f = Folder::new();
    f.file("a/x.obj", grid(2));
    f.file("b/x.obj", grid(2));
    f.file("y.obj", grid(2));
    f.file("plain", "a file");
    for args in [vec!["a/x.obj", "b/x.obj", "-o", "out"], vec!["a/x.obj", "./a/../a/x.obj"]] {
        let run = f.lodc(["build"].iter().chain(&args)).ends(2);
        assert_eq!(run.errors(), 2, "an error for each: {}", run.err);
    }
    for args in [
        vec!["a/x.obj", "y.obj", "-o", "-"],
        vec!["a/x.obj", "-o", "-", "--report", "json"],
        vec!["a/x.obj", "-o", "a/x.obj"],
        vec!["a/x.obj", "-o", "a/../a/x.obj"],
        vec!["a/x.obj", "y.obj", "-o", "plain"],
        vec!["a/x.obj", "--depfile", "a/x.obj.lodc"],
        vec!["-", "-", "-o", "out"],
        vec!["-"],
    ] {
        f.lodc(["build"].iter().chain(&args)).fails(2);
    }
    assert_eq!(f.names(), ["a", "b", "plain", "y.obj"]);
    f.lodc(["build", "y.obj", "-o", "y.lodc", "-q"]).ends(0);
    for args in [
        vec!["-o", "-", "--json"],
        vec!["-o", "-", "--format", "gltf"],
        vec!["-o", "y.lodc", "--format", "glb"],
        vec!["-o", "z.xyz"],
    ] {
        f.lodc(["extract", "y.lodc", "--ratio", "0.5"].iter().chain(&args)).fails(2);
    }
}

#[test]
fn versions_are_a_document_if_asked_for() {
    let f = Folder::new();
    let document = f.lodc(["--version", "--json"]).ends(0).json();
    assert_eq!(document["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(document["formats"], serde_json::json!({ "lodc": 1, "lods": 1 }));
    let features = document["features"].as_array().expect("a list");
    assert_eq!(features.contains(&"gpu".into()), cfg!(feature = "gpu"));
    assert_eq!(document, f.lodc(["--json", "-V"]).ends(0).json());
    f.lodc(["--json"]).ends(2);
}
