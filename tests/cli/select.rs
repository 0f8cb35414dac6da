//! `lodc select`: the level for a distance, and levels under a budget.

use crate::support::{Folder, grid, scene};

#[test]
fn the_level_for_a_distance_is_the_one_that_its_error_gives() {
    let f = Folder::new();
    f.file("a.obj", grid(12));
    f.lodc(["build", "a.obj", "-o", "a.lodc", "-q"]).ends(0);
    let mut before = u64::MAX;
    for distance in ["1", "10", "100", "1000", "100000"] {
        let args = ["select", "a.lodc", "--pixels", "1", "--distance", distance, "--json"];
        let level = f.lodc(args).ends(0).json();
        let (triangles, error) = (level["triangles"].as_u64().expect("a count"), &level["error"]);
        assert!(level["projected_pixels"].as_f64().expect("a number") <= 1.0);
        assert!(triangles <= before && triangles > 0);
        before = triangles;
        // Never finer than the same error asks for, but for the width of a step of errors.
        let bound = 1.008 * error.as_f64().expect("a number") + 1e-12;
        let args = ["extract", "a.lodc", "--error", &bound.to_string(), "-o", "b.obj", "--json"];
        let extracted = f.lodc(args).ends(0).json();
        assert!(extracted["triangles"].as_u64().expect("a count") <= triangles);
        assert!(level["lod"].is_u64());
    }
    assert!(before < 10, "{before} triangles far away");
}

#[test]
fn instances_share_a_budget() {
    let f = Folder::new();
    f.file("a.obj", grid(12));
    f.file("s.gltf", scene(&[1.0, 3.0], 6));
    f.lodc(["build", "a.obj", "-o", "a.lodc", "-q"]).ends(0);
    f.lodc(["build", "s.gltf", "-o", "s.lodc", "-q"]).ends(0);
    let lines: Vec<String> = (1..=20)
        .map(|i| {
            let file = if i % 4 == 0 { "s.lodc" } else { "a.lodc" };
            format!(r#"{{"file": "{file}", "position": [0, 0, {}], "scale": 2}}"#, -30 * i)
        })
        .collect();
    f.file("scene.jsonl", lines.join("\n"));
    let eye = ["--eye", "0,0,40", "--json"];
    let select = |more: &[&str]| {
        f.lodc(["select", "--scene", "scene.jsonl"].iter().chain(&eye).chain(more)).ends(0).json()
    };
    let chosen = select(&["--budget", "1500"]);
    let instances = chosen["instances"].as_array().expect("instances");
    assert_eq!(instances.len(), 20);
    let sum: u64 = instances.iter().map(|i| i["triangles"].as_u64().expect("a count")).sum();
    assert_eq!(chosen["triangles"].as_u64(), Some(sum));
    assert!(sum <= 1500);
    assert!(instances[0]["triangles"].as_u64() >= instances[17]["triangles"].as_u64());
    assert!(chosen["pixels"].as_f64().expect("a bound") < 1e6);
    // No bound lets the coarsest levels fit, from wherever they are seen.
    for eye in ["0,0,40", "0,0,-30"] {
        let args = ["select", "--scene", "scene.jsonl", "--eye", eye, "--budget", "1", "--json"];
        assert!(f.lodc(args).ends(0).json()["pixels"].is_null());
    }
    let args = ["select", "--scene", "-", "--eye", "0,0,40", "--budget", "1500", "--json"];
    assert_eq!(f.lodc_with(args, lines.join("\n").as_bytes()).ends(0).json(), chosen);
    let behind = select(&["--budget", "1500", "--target", "0,0,100"]);
    assert!(behind["triangles"].as_u64() < chosen["triangles"].as_u64());
    f.file("wrong.jsonl", "{\"file\": \"a.lodc\"}");
    let run = f.lodc(["select", "--scene", "wrong.jsonl", "--eye", "0,0,0", "--budget", "9"]);
    assert!(run.fails(3).err.contains("wrong.jsonl: line 1"));
    f.lodc(["select", "a.lodc", "--pixels", "1"]).ends(2);
    f.lodc(["select", "a.lodc", "--pixels", "0", "--distance", "1"]).ends(2);
}
