//! `lodc verify`: it finds every difference and never cries wolf.

use crate::support::{Folder, grid, scene};

fn built() -> Folder {
    let f = Folder::new();
    f.file("g.obj", grid(8));
    f.lodc(["build", "g.obj", "-o", "g.lodc", "-q"]).ends(0);
    f
}

#[test]
fn a_sound_file_passes_every_check_and_its_source_is_recognised() {
    let f = built();
    let run = f.lodc(["verify", "g.lodc", "--source", "g.obj"]).ends(0);
    assert!(run.text().lines().count() >= 3, "{}", run.text());
    assert!(
        run.text().lines().all(|l| l.starts_with("g.lodc: ") && l.contains(": ok, ")),
        "{}",
        run.text()
    );
    let report = f.lodc(["verify", "g.lodc", "--json", "--stride", "3"]).ends(0).json();
    assert_eq!((&report["schema_version"], &report["ok"]), (&1.into(), &true.into()));
    let checks = report["files"][0]["checks"].as_array().expect("checks");
    for key in ["object", "model", "device", "adapter", "lods", "ok", "first_difference"] {
        assert!(checks.iter().all(|c| c.get(key).is_some()), "{key}");
    }
    assert!(checks.iter().any(|c| c["model"] == "interactive" && c["lods"].as_u64() > Some(10)));
}

#[test]
fn a_sequence_without_models_is_enough_for_levels_and_says_what_it_lacks() {
    let f = Folder::new();
    f.file("g.obj", grid(8));
    f.lodc(["build", "g.obj", "-o", "g.lodc", "-q"]).ends(0);
    let report = f.lodc(["build", "g.obj", "-o", "n.lodc", "--models", "none", "--report", "json"]);
    let report = report.ends(0).json();
    assert_eq!(report["inputs"][0]["models"].as_array().map(Vec::len), Some(0));
    let stages = report["inputs"][0]["stages"].as_array().expect("stages");
    assert!(
        stages
            .iter()
            .all(|s| !["strips", "models", "check"].contains(&s["name"].as_str().expect("a name")))
    );
    let info = f.lodc(["info", "n.lodc"]).ends(0);
    assert!(info.text().contains("no models, only the collapse sequence"), "{}", info.text());
    let run = f.lodc(["verify", "n.lodc", "--source", "g.obj"]).ends(0);
    assert!(run.text().contains("models, replay, cpu: skipped"), "{}", run.text());
    for name in ["g", "n"] {
        let (input, output) = (format!("{name}.lodc"), format!("{name}.ply"));
        f.lodc(["extract", &input, "--ratio", "0.3", "--model", "reference", "-o", &output])
            .ends(0);
        f.lodc(["chain", &input, "-o", &format!("{name}.glb")]).ends(0);
        f.lodc(["pack", &input, "-o", &format!("{name}.lods")]).ends(0);
    }
    for kind in ["ply", "glb", "lods"] {
        assert!(f.read(&format!("g.{kind}")) == f.read(&format!("n.{kind}")), "{kind}");
    }
    let run = f.lodc(["extract", "n.lodc", "--lod", "1", "-o", "x.ply", "--model", "speed"]);
    assert!(run.ends(2).err.contains("has no model speed (it has: reference)"));
}

#[test]
fn a_scene_is_checked_object_by_object() {
    let f = Folder::new();
    f.file("s.gltf", scene(&[1.0, 3.0], 5));
    f.lodc(["build", "s.gltf", "-o", "s.lodc", "-q"]).ends(0);
    let report = f.lodc(["verify", "s.lodc", "--source", "s.gltf", "--json"]).ends(0).json();
    let checks = report["files"][0]["checks"].as_array().expect("checks");
    for object in ["grid0", "grid1"] {
        assert!(checks.iter().any(|c| c["object"] == object && c["ok"] == true), "{object}");
    }
}

#[test]
fn another_source_is_a_difference_that_is_shown() {
    let f = built();
    let moved = grid(8).replacen("v 1 1 ", "v 1 1.0000001 ", 1);
    f.file("moved.obj", &moved);
    f.file("flipped.obj", grid(8).replacen("f 1 2 11 10", "f 2 1 10 11", 1));
    f.file("smaller.obj", grid(7));
    for other in ["moved.obj", "flipped.obj", "smaller.obj"] {
        let run = f.lodc(["verify", "g.lodc", "--source", other]).ends(1);
        assert!(run.text().contains("DIFFERENT"), "{other}: {}", run.text());
        let report = f.lodc(["verify", "g.lodc", "--source", other, "--json"]).ends(1).json();
        assert_eq!(report["ok"], false);
    }
}

#[test]
fn of_meshes_with_the_same_content_the_one_of_the_name_is_the_source() {
    let f = Folder::new();
    for name in ["in/a.obj", "in/a2.obj", "in/b.obj", "in/x/a.obj"] {
        f.file(name, grid(3));
    }
    f.lodc(["build", "in", "-o", "out", "-q"]).ends(0);
    f.lodc(["verify", "out", "--source", "in", "-q"]).ends(0);
    f.lodc(["build", "in/b.obj", "-o", "b.lodc", "-q"]).ends(0);
    f.lodc(["verify", "b.lodc", "--source", "in", "-q"]).ends(0);
}

#[test]
fn a_damaged_file_is_never_read_as_a_good_one() {
    let f = built();
    let whole = f.read("g.lodc");
    for at in (0..whole.len()).step_by(whole.len() / 60 + 1) {
        let mut damaged = whole.clone();
        damaged[at] ^= 1 << (at % 8);
        f.file("d.lodc", &damaged);
        f.lodc(["verify", "d.lodc"]).fails(3);
        f.file("d.lodc", &whole[..at]);
        f.lodc(["info", "d.lodc"]).fails(3);
    }
    f.file("d.lodc", [whole.as_slice(), b"\0"].concat());
    f.lodc(["extract", "d.lodc", "--ratio", "0.5", "-o", "x.obj"]).fails(3);
    assert!(!f.has("x.obj"));
    f.lodc(["verify", "g.obj"]).fails(3);
    let run = f.lodc(["verify", "d.lodc", "g.lodc", "missing.lodc", "--json"]).ends(3);
    let report = run.json();
    assert_eq!(report["files"][0]["ok"], false);
    assert!(report["files"][0]["error"].is_string());
    assert_eq!(report["files"][1]["ok"], true, "the others are still done");
}

#[test]
fn a_gpu_that_is_required_and_not_there_is_6_and_never_a_pass() {
    let f = built();
    for gpu in ["--gpu", "--gpu=require"] {
        let run = f.without_gpu(["verify", "g.lodc", gpu]).ends(6);
        assert!(
            run.text().is_empty() && run.err.contains("GPU") && run.errors() == 1,
            "{}",
            run.err
        );
    }
    let report = f.without_gpu(["verify", "g.lodc", "--gpu=auto", "--json"]).ends(0).json();
    let checks = report["files"][0]["checks"].as_array().expect("checks");
    let gpu = checks.iter().find(|c| c["device"] == "gpu").expect("it is reported");
    assert!(gpu["ok"].is_null() && gpu["skipped"].is_string(), "{gpu}");
    assert!(f.without_gpu(["verify", "g.lodc", "--gpu=auto"]).ends(0).text().contains("skipped"));
    assert_eq!(
        f.lodc(["verify", "g.lodc", "--gpu", "--adapter", "no such adapter"]).status,
        Some(6)
    );
    f.lodc(["verify", "g.lodc", "--adapter", "any"]).ends(2);
}

#[test]
fn a_gpu_shows_what_the_cpu_shows() {
    let f = Folder::new();
    f.file("g.obj", grid(8));
    f.file("s.gltf", scene(&[1.0, 3.0], 5));
    f.lodc(["build", "g.obj", "-o", "g.lodc", "-q"]).ends(0);
    f.lodc(["build", "s.gltf", "-o", "s.lodc", "-q"]).ends(0);
    let run = f.lodc(["verify", "g.lodc", "s.lodc", "--gpu", "--json"]);
    let Some(run) = run.drawn() else { return };
    let report = run.json();
    for (file, objects) in [(0, 1), (1, 2)] {
        let checks = report["files"][file]["checks"].as_array().expect("checks");
        let gpu: Vec<_> = checks.iter().filter(|c| c["device"] == "gpu").collect();
        assert!(gpu.len() >= objects, "{report}");
        assert!(
            gpu.iter().all(|c| c["ok"] == true
                && c["adapter"].is_string()
                && c["lods"].as_u64() > Some(10))
        );
    }
}

#[test]
fn junit_holds_the_same_checks() {
    let f = built();
    f.lodc(["verify", "g.lodc", "--junit", "r.xml", "-q"]).ends(0);
    let xml = String::from_utf8(f.read("r.xml")).expect("text");
    assert!(
        xml.starts_with("<?xml") && xml.contains("failures=\"0\"") && xml.contains("<testcase"),
        "{xml}"
    );
    f.lodc(["verify", "g.lodc", "--source", "missing.obj", "--junit", "r.xml", "-q"]).ends(3);
    assert!(String::from_utf8(f.read("r.xml")).expect("text").contains("errors=\"1\""));
}

/// On a system with a GPU and without one, and whatever a driver's libraries have to say.
#[test]
fn nothing_is_printed_but_what_the_program_says() {
    let f = built();
    let run = f.lodc(["verify", "g.lodc", "--gpu=auto", "-q"]);
    assert!(run.err.is_empty(), "{}", run.err);
    let run = f.lodc(["verify", "g.lodc", "--gpu=auto", "--adapter", "none such", "-q"]);
    assert!(run.err.is_empty(), "{}", run.err);
}
