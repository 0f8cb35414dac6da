//! `lodc bench --crowd`: levels by distance, charts and a picture of them, and draws on a device.

use crate::support::{Folder, grid};
use serde_json::Value;

fn number(value: &Value, path: &str) -> f64 {
    value
        .pointer(path)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("no number at {path} in {value}"))
}

/// Triangles and times per frame of every structure, by levels of all kinds.
#[test]
fn a_crowd_has_fewer_triangles_by_distance_and_every_structure_the_same() {
    let f = Folder::new();
    f.file("g.obj", grid(12));
    f.file("h.obj", grid(6));
    let crowd = |more: &[&str]| {
        let args = ["bench", "g.obj", "h.obj", "--crowd", "--instances", "30", "--seconds", "6"];
        f.lodc(args.iter().chain(&["--json"]).chain(more)).ends(0).json()["crowd"].clone()
    };
    let report = crowd(&[]);
    assert_eq!(report["frames"], 60);
    let none = report["none"]["triangles_per_frame"].as_f64().expect("a mean");
    assert!((none - 15.0 * (288.0 + 72.0)).abs() < 1e-9, "{none}");
    let models = report["models"].as_object().expect("models");
    let names: Vec<&str> = models.keys().map(String::as_str).collect();
    assert_eq!(names, ["interactive", "lodstrips", "masking", "progressive_mesh", "speed"]);
    for (name, model) in models {
        let of = |policy: &str, key: &str| model[policy][key].as_f64().expect("a number");
        let (every, five) =
            (of("continuous", "triangles_per_frame"), of("discrete", "triangles_per_frame"));
        assert!(0.0 < every && every < five && five < none, "{name}: {every} {five} {none}");
        assert_eq!(every, models["speed"]["continuous"]["triangles_per_frame"]);
        assert!(of("continuous", "extraction_ms_per_frame") > 0.0, "{name}");
        // Few levels are shared by many, and few change from frame to frame.
        assert!(of("discrete", "shared") > of("continuous", "shared"), "{name}");
        assert!(of("discrete", "changed") < of("continuous", "changed"), "{name}");
    }
    let still = |seed: &str| crowd(&["--no-times", "--seed", seed]);
    assert_eq!(still("7"), still("7"), "the same but for times");
    assert!(still("7") != still("8"));
    f.lodc(["bench", "g.obj", "--instances", "3"]).ends(2);
}

#[test]
fn plots_of_a_crowd_show_what_its_report_says() {
    let f = Folder::new();
    f.file("g.obj", grid(8));
    let crowd = ["bench", "g.obj", "--crowd", "--instances", "9", "--seconds", "30", "--json"];
    let run = |more: &[&str]| f.lodc(crowd.iter().chain(more)).ends(0).json()["crowd"].clone();
    let report = run(&["--plots", "p", "--rounds", "2"]);
    let list = |value: &Value| -> Vec<f64> {
        let list = value.as_array().expect("a list");
        list.iter().map(|v| v.as_f64().expect("a number")).collect()
    };
    let seconds = list(&report["curve"]["seconds"]);
    assert_eq!((seconds.len(), seconds.last()), (100, Some(&30.0)));
    for (policy, of) in [("continuous", "/models/speed/continuous"), ("none", "/none")] {
        let curve = list(&report["curve"][policy]);
        let mean = curve.iter().sum::<f64>() / 100.0;
        let stated = number(&report, &format!("{of}/triangles_per_frame"));
        assert!((mean - stated).abs() < 1e-6 * stated, "{policy}: {mean}, not {stated}");
    }
    let times = &report["models"]["masking"]["discrete"]["extraction_ms_curve"];
    assert_eq!(list(times).len(), 100);
    let read = |name: &str| std::fs::read_to_string(f.path().join("p").join(name));
    let triangles = read("crowd-triangles.svg").expect("a chart");
    assert_eq!(triangles.matches(">continuous<").count(), 1);
    // Grid lines have one place each, curves have a hundred.
    assert_eq!(triangles.split("d=\"M").filter(|d| d.matches('L').count() == 99).count(), 3);
    assert!(read("crowd-extraction.svg").expect("a chart").contains(">progressive_mesh<"));
    run(&["--plots", "q", "--no-times"]);
    let entries = std::fs::read_dir(f.path().join("q")).expect("a folder");
    assert_eq!(entries.count(), 2, "no times, no charts of them");
    // Where a discrete level begins the continuous one is the same; in between it has fewer.
    let far = &report["by_distance"];
    let (all, five) = (list(&far["continuous"]), list(&far["discrete"]));
    assert_eq!((all.len(), all[0]), (101, five[0]));
    for (i, (all, five)) in all.iter().zip(&five).enumerate() {
        assert!(all <= five && (i % 20 > 0 || i == 100 || all == five), "{i}: {all}, {five}");
    }
    let spread = &report["models"]["speed"]["continuous"]["extraction_spread"];
    assert_eq!(spread["rounds"], 2);
    f.lodc(["bench", "g.obj", "--crowd", "--plots", "g.obj/x"]).ends(4);
}

/// The same crowd on a device: every way to choose levels is drawn, instances of one level at once.
#[test]
fn a_crowd_is_drawn_by_instances_or_refused_without_a_device() {
    let f = Folder::new();
    f.file("g.obj", grid(8));
    let crowd = ["bench", "g.obj", "--crowd", "--instances", "9", "--seconds", "2", "--json"];
    let all = |more: &[&'static str]| [&crowd[..], more].concat();
    let run = f.without_gpu(all(&["--gpu"])).ends(6);
    assert!(run.errors() == 1 && run.err.contains("no graphics adapter"), "{}", run.err);
    let run = f.without_gpu(all(&["--gpu=auto", "--picture", "c.png"])).ends(0);
    assert!(run.json()["crowd"]["gpu"].is_null());
    let picture = std::fs::read(f.path().join("c.png")).expect("a picture");
    assert!(picture.starts_with(b"\x89PNG"));
    let run = f.lodc(all(&["--gpu", "--rounds", "1"]));
    let Some(run) = run.drawn() else { return };
    let report = run.json()["crowd"]["gpu"].clone();
    assert_eq!(report["frames"], 20);
    let of = |policy: &str, key: &str| number(&report, &format!("/{policy}/{key}"));
    for policy in ["continuous", "discrete", "none"] {
        assert!(of(policy, "draw_ms_per_frame") > 0.0, "{policy}");
    }
    // All of one level in the only pose: one draw of one list.
    assert_eq!(of("none", "draws_per_frame"), 1.0);
    assert_eq!(of("none", "index_bytes_per_frame"), 12.0 * 128.0);
    assert_eq!(of("none", "triangles_per_frame"), 9.0 * 128.0);
    assert!(of("discrete", "draws_per_frame") <= 5.0 && of("continuous", "draws_per_frame") > 1.0);
    let (every, five) = ("continuous", "discrete");
    assert!(of(every, "triangles_per_frame") < of(five, "triangles_per_frame"));
}
