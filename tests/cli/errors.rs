//! Stated errors of levels: levels chosen by `--max-error` keep it, and `verify` finds a file whose
//! errors are wrong.

use crate::support::{Folder, grid};
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
    f.lodc(["build", "g.obj", "-o", "g.lodc", "-q"]).ends(0);
    f
}

/// Multiplies all stored errors and root mean square distances, and says which program wrote them.
fn spoil(f: &Folder, [error, rms]: [f32; 2], program: &str) {
    let mut file = lodc::read(&f.read("g.lodc")).expect("a sound file");
    for object in &mut file.objects {
        let parts = object.simplified.collapses().parts().clone();
        let by = |factor: f32| move |&e: &f32| if e.is_finite() { e * factor } else { e };
        let scaled =
            |all: &[f32], factor: f32| -> Vec<f32> { all.iter().map(by(factor)).collect() };
        let largest: Vec<f32> = scaled(&parts.step_errors, error);
        let rms: Vec<f32> = scaled(&parts.step_rms, rms);
        // A mean is not above the largest.
        let rms = rms.iter().zip(&largest).map(|(rms, largest)| rms.min(*largest)).collect();
        let simplified = (*object.simplified).clone().with_distances(largest, rms);
        object.simplified = Arc::new(simplified.expect("they do not fall"));
    }
    file.made_from.as_mut().expect("a file's origin").program = program.to_owned();
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
fn errors_that_are_wrong_are_found() {
    let f = built();
    let line = |text: &str, check: &str| {
        let line = text.lines().find(|line| line.contains(check));
        line.map(str::to_owned).unwrap_or_default()
    };
    let own = concat!("lodc ", env!("CARGO_PKG_VERSION"));
    let sound = f.lodc(["verify", "g.lodc"]).ends(0).text();
    for check in ["errors hold", "errors measured again"] {
        assert!(line(&sound, check).contains(": ok, "), "{check}: {sound}");
    }
    // What this version wrote it measures again, to the last bit.
    for factors in [[0.5, 1.0], [0.9, 1.0], [1.5, 1.0], [4.0, 1.0], [1.0, 0.0], [1.0, 0.9]] {
        spoil(&f, factors, own);
        let found = line(&f.lodc(["verify", "spoiled.lodc"]).ends(1).text(), "measured again");
        assert!(found.contains("DIFFERENT"), "{factors:?}: {found}");
    }
    // What others wrote is measured in its own way.
    for (factor, status) in [(0.0, 1), (0.5, 1), (1.0, 0), (1.5, 0), (10.0, 1)] {
        spoil(&f, [factor, 1.0], "lodc 0.0.1");
        let text = f.lodc(["verify", "spoiled.lodc"]).ends(status).text();
        assert_eq!(line(&text, "measured again"), "");
        assert_eq!(
            line(&text, "errors hold").contains("DIFFERENT"),
            status == 1,
            "{factor}: {text}"
        );
    }
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
    let args = ["extract", "estimate.lodc", "--error", "1%", "-o", "l.obj", "--json"];
    let run = f.lodc(args.iter().chain(&["--no-refit"])).ends(0);
    assert!(run.json()["rms"].is_null());
    // Levels with other vertices are measured.
    assert!(f.lodc(args).ends(0).json()["rms"].is_f64());
    let text = f.lodc(["verify", "estimate.lodc"]).ends(0).text();
    assert!(text.contains("errors hold, cpu: skipped"), "{text}");
}
