//! Limits on work: processor time and decoded pixels.

use crate::support::{Folder, grid};
use lodc_formats::images::png;
use lodc_scene::Image;
use std::collections::BTreeMap;

/// Everything in a folder.
fn content(f: &Folder) -> BTreeMap<String, Vec<u8>> {
    let files = f.names().into_iter().filter(|name| f.join(name).is_file());
    files.map(|name| (name.clone(), f.read(&name))).collect()
}

#[test]
fn work_that_takes_too_long_ends_with_5_and_writes_nothing_and_other_results_stay_as_they_are() {
    let f = Folder::new();
    f.file("a.obj", grid(9));
    f.lodc(["build", "a.obj", "-o", "a.lodc", "-q"]).ends(0);
    f.lodc(["pack", "a.lodc", "-o", "a.lods", "-q"]).ends(0);
    let commands: [&[&str]; 14] = [
        &["build", "a.obj", "-o", "out.lodc"],
        &["extract", "a.lodc", "--ratio", "0.5", "-o", "out.glb"],
        &["chain", "a.obj", "--levels", "50%", "-o", "out.glb"],
        &["info", "a.lodc"],
        &["info", "a.lods"],
        &["verify", "a.lodc"],
        &["compare", "a.obj", "a.lodc", "--ratio", "0.5", "--views", "0"],
        &["report", "a.lodc", "-o", "out.html"],
        &["view", "a.lodc", "-o", "out.html"],
        &["pack", "a.lodc", "-o", "out.lods"],
        &["unpack", "a.lods", "-o", "out.lodc"],
        &["unpack", "a.lods", "-o", "out.obj"],
        &["strips", "a.obj", "-o", "out.strips"],
        &["select", "a.lodc", "--pixels", "1", "--distance", "5"],
    ];
    let before = content(&f);
    for args in commands {
        let late = f.lodc(args.iter().chain(&["--limit", "time=0s"])).fails(5);
        assert!(late.err.contains("--limit time="), "{}", late.err);
        assert!(late.out.is_empty() && late.err.lines().count() == 1, "{late:?}");
        assert_eq!(content(&f), before, "{args:?}");
    }
    for args in commands {
        let made = |limit: &[&str]| {
            let run = f.lodc(args.iter().chain(&["-q"]).chain(limit)).ends(0);
            let mut files = content(&f);
            files.retain(|name, _| !before.contains_key(name));
            for name in files.keys() {
                std::fs::remove_file(f.join(name)).expect("a result");
            }
            (run.out, files)
        };
        assert_eq!(made(&[]), made(&["--limit", "time=1h", "--limit", "pixels=1"]), "{args:?}");
    }
    f.lodc(["bench", "a.obj", "--limit", "time=0s"]).ends(5);
}

#[test]
fn of_several_assets_only_the_one_that_takes_too_long_fails_and_that_is_not_recorded() {
    let f = Folder::new();
    let line = |name: &str, time: &str| {
        format!("{{\"input\": \"{name}\", \"options\": {{\"limit\": \"time={time}\"}}}}\n")
    };
    for name in ["a.obj", "b.obj", "c.obj"] {
        f.file(name, grid(5));
    }
    let list =
        |time: &str| [line("a.obj", "1h"), line("b.obj", time), line("c.obj", "1h")].concat();
    let args = ["build", "--manifest", "list", "--if-changed", "--report", "json"];
    f.file("list", list("0s"));
    let run = f.lodc(args).ends(5);
    let told = run.json();
    let statuses: Vec<_> = (0..3).map(|i| told["inputs"][i]["status"].as_u64()).collect();
    assert_eq!(statuses, [Some(0), Some(5), Some(0)]);
    assert!(run.err.contains("b.obj: took more than 0 s"), "{}", run.err);
    assert!(f.has("a.obj.lodc") && !f.has("b.obj.lodc") && f.has("c.obj.lodc"), "{:?}", f.names());
    // Another limit is no other asset: what is there is up to date, the rest is made.
    f.file("list", list("1h"));
    let told = f.lodc(args).ends(0).json();
    let fresh: Vec<_> = (0..3).map(|i| told["inputs"][i]["up_to_date"].as_bool()).collect();
    assert_eq!(fresh, [Some(true), Some(false), Some(true)]);
}

#[test]
fn more_pixels_than_allowed_end_with_5_where_images_are_decoded() {
    let f = Folder::new();
    f.file("t.png", png(&Image { width: 8, height: 8, bytes: vec![200; 256] }));
    f.file("s.mtl", "newmtl m\nmap_Kd t.png\n");
    let textured = format!("mtllib s.mtl\nusemtl m\n{}", grid(6));
    f.file("s.obj", textured);
    let hybrid = ["build", "s.obj", "-o", "s.lodc", "--metric", "hybrid", "-q"];
    let run = f.lodc(hybrid.iter().chain(&["--limit", "pixels=63"])).fails(5);
    assert!(run.err.contains("s.obj: ") && run.err.contains("63 pixels"), "{}", run.err);
    assert!(!f.has("s.lodc"));
    f.lodc(hybrid.iter().chain(&["--limit", "pixels=64"])).ends(0);
    // Nothing is decoded here.
    f.lodc(["build", "s.obj", "-o", "s.lodc", "-q", "--limit", "pixels=0"]).ends(0);
}
