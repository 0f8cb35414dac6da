//! Errors of levels: they hold, they are asked for, and a file whose errors are wrong is found.

use crate::support::{Folder, grid};
use lodc_formats::lodc;
use std::sync::Arc;

/// A hilly grid and its file.
fn built() -> Folder {
    let f = Folder::new();
    let hill = |line: &str| match line.strip_prefix("v ") {
        Some(rest) => {
            let c: Vec<f64> = rest.split(' ').map(|c| c.parse().expect("a number")).collect();
            format!("v {} {} {}\n", c[0], c[1], (c[0] * c[0] - 2.0 * c[1]) * 0.05 * c[1])
        }
        None => format!("{line}\n"),
    };
    f.file("g.obj", grid(14).lines().map(hill).collect::<String>());
    f.lodc(["build", "g.obj", "-q"]).ends(0);
    f
}

/// Multiplies all stored distances.
fn spoil(f: &Folder, factor: f32) {
    let mut file = lodc::read(&f.read("g.lodc")).expect("a sound file");
    for object in &mut file.objects {
        let parts = object.simplified.collapses().parts().clone();
        let scaled = |all: &[f32]| all.iter().map(|e| e * factor).collect();
        let (largest, rms) = (scaled(&parts.step_errors), scaled(&parts.step_rms));
        let simplified = (*object.simplified).clone().with_distances(largest, rms);
        object.simplified = Arc::new(simplified.expect("they do not fall"));
    }
    f.file("spoiled.lodc", lodc::write(&file));
}

#[test]
fn levels_are_measured_by_compare_within_what_they_state() {
    let f = built();
    for share in ["0.6", "0.3", "0.1", "0.04"] {
        let run = f.lodc(["extract", "g.lodc", "--ratio", share, "-o", "l.obj", "--json"]).ends(0);
        let report = run.json();
        let [error, rms] = ["error", "rms"].map(|k| report[k].as_f64().expect("a distance"));
        let run = f.lodc(["compare", "g.obj", "l.obj", "--views", "0", "--json"]).ends(0);
        let measured = run.json()["hausdorff"]["max"].as_f64().expect("a distance");
        assert!(measured <= 1.05 * error && error <= 1.4 * measured, "{share}: {error} {measured}");
        assert!(rms > 0.0 && rms <= error, "{share}");
    }
}

#[test]
fn levels_are_asked_for_by_root_mean_square_distance() {
    let f = built();
    let lods = |selector: [&str; 2]| {
        let args = ["extract", "g.lodc", selector[0], selector[1], "-o", "l.obj", "--json"];
        f.lodc(args).ends(0).json()
    };
    let (by_error, by_rms) = (lods(["--error", "0.2"]), lods(["--rms", "0.2"]));
    assert!(by_rms["lod"].as_u64() > by_error["lod"].as_u64(), "{by_rms} {by_error}");
    assert!(by_rms["rms"].as_f64() <= Some(0.2));
    assert!(lods(["--rms", "1%"])["rms"].as_f64() > Some(0.0));
    let info = f.lodc(["info", "g.lodc", "--json"]).ends(0).json();
    let object = &info["objects"][0];
    assert_eq!(object["errors"], "measured");
    let lods = object["lods"].as_array().expect("a table");
    assert!(lods.iter().all(|l| l["rms"].as_f64() <= l["error"].as_f64()));
}

#[test]
fn errors_that_are_half_of_the_true_ones_are_found() {
    let f = built();
    let line = |text: String| {
        text.lines().find(|l| l.contains("errors hold")).expect("the check").to_owned()
    };
    assert!(line(f.lodc(["verify", "g.lodc"]).ends(0).text()).contains(": ok, "));
    spoil(&f, 0.5);
    let found = line(f.lodc(["verify", "spoiled.lodc"]).ends(1).text());
    assert!(found.contains("DIFFERENT") && found.contains("measured are"), "{found}");
    spoil(&f, 1.5);
    f.lodc(["verify", "spoiled.lodc"]).ends(0);
}

#[test]
fn files_without_measured_errors_say_that_they_are_estimates() {
    let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/golden/v1/two_parts.lodc");
    let f = Folder::new();
    f.file("estimate.lodc", std::fs::read(golden).expect("a golden file"));
    let info = f.lodc(["info", "estimate.lodc", "--json"]).ends(0).json();
    assert_eq!(info["format_version"], 1);
    for object in info["objects"].as_array().expect("objects") {
        assert_eq!(object["errors"], "estimate");
        assert!(object["lods"].as_array().expect("a table").iter().all(|l| l["rms"].is_null()));
    }
    assert!(f.lodc(["info", "estimate.lodc"]).ends(0).text().contains("error: estimate"));
    f.lodc(["extract", "estimate.lodc", "--rms", "1%", "-o", "l.obj"]).fails(2);
    let run =
        f.lodc(["extract", "estimate.lodc", "--error", "1%", "-o", "l.obj", "--json"]).ends(0);
    assert!(run.json()["rms"].is_null());
    let text = f.lodc(["verify", "estimate.lodc"]).ends(0).text();
    assert!(text.contains("errors hold, cpu: skipped"), "{text}");
}
