//! Same input, options and version: same bytes.

use crate::support::{Folder, LODC, Run, grid, scene};
use std::process::Command;

#[test]
fn the_bytes_depend_on_neither_threads_nor_surroundings() {
    let f = Folder::new();
    f.file("in/g.obj", grid(20));
    f.file("in/s.gltf", scene(&[1.0, 0.25, 4.0, 2.0, 0.5], 9));
    for name in ["g.obj", "s.gltf"] {
        let input = f.join("in").join(name);
        let mut seen: Option<Vec<u8>> = None;
        for (i, jobs) in ["1", "2", "8", "1", "2", "8", "2", "8"].into_iter().enumerate() {
            let elsewhere = f.join(&format!("elsewhere {i}"));
            std::fs::create_dir_all(&elsewhere).expect("a folder");
            let (zone, language) =
                [("UTC", "C"), ("Asia/Tokyo", "de_DE.UTF-8"), ("America/Lima", "tr_TR.UTF-8")]
                    [i % 3];
            let mut command = Command::new(LODC);
            command
                .arg("build")
                .arg(&input)
                .args(["-o", "out.lodc", "--jobs", jobs, "-q"])
                .current_dir(&elsewhere);
            command.env("TZ", zone).env("LANG", language).env("LC_ALL", language);
            Run::of(&mut command).ends(0);
            let bytes = std::fs::read(elsewhere.join("out.lodc")).expect("the output");
            assert!(
                seen.is_none_or(|first| first == bytes),
                "{name} with {jobs} jobs, {zone}, {language}"
            );
            seen = Some(bytes);
        }
    }
}

#[test]
fn the_bytes_do_not_depend_on_the_name_of_the_folder_or_the_output() {
    let f = Folder::new();
    f.file("one/g.obj", grid(6));
    f.file("two/g.obj", grid(6));
    f.lodc(["build", "one/g.obj", "-o", "one/g.lodc", "-q"]).ends(0);
    f.lodc(["build", "two/g.obj", "-o", "other.lodc", "-q"]).ends(0);
    assert_eq!(f.read("one/g.lodc"), f.read("other.lodc"));
    let to =
        |name: &str| f.lodc(["extract", "other.lodc", "--ratio", "0.4", "-o", name, "-q"]).ends(0);
    to("a.glb");
    to("b.glb");
    assert_eq!(f.read("a.glb"), f.read("b.glb"));
}

/// Of a mesh only the levels that are written are measured, of a file the whole curve was: what is
/// stated may differ, and nothing else.
#[test]
fn a_mesh_and_its_file_give_the_same_levels() {
    let f = Folder::new();
    f.file("in/s.gltf", scene(&[1.0, 0.25, 4.0, 2.0, 0.5], 12));
    let fixtures = ["machine_part.glb", "terrain.glb"].map(|name| {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures").join(name);
        path.to_str().expect("a name in UTF-8").to_owned()
    });
    for input in fixtures.iter().map(String::as_str).chain(["in/s.gltf"]) {
        f.lodc(["build", input, "-o", "m.lodc", "--models", "none", "-q"]).ends(0);
        let both = |words: &[&str]| {
            ["mesh", "file"].map(|from| {
                let source = if from == "mesh" { input } else { "m.lodc" };
                let output = format!("{from}.gltf");
                let args = [words[0], source, "-o", &output, "--json", "-q"];
                let report = f.lodc(args.iter().chain(&words[1..])).ends(0).json();
                (f.read(&format!("{from}.bin")), report)
            })
        };
        for selector in [["--ratio", "0.5"], ["--ratio", "0.1"], ["--triangles", "40"]] {
            let [mesh, file] = both(&[&["extract"][..], &selector].concat());
            assert_eq!(mesh.0, file.0, "{input} {selector:?}");
            assert_eq!(mesh.1["lod"], file.1["lod"]);
            let error = |report: &serde_json::Value| report["error"].as_f64().expect("a number");
            // The bounds of levels by themselves are at most 2 % above the distances.
            assert!(error(&mesh.1) <= 1.02 * error(&file.1), "{input} {selector:?}");
        }
        let [mesh, file] = both(&["chain"]);
        assert_eq!(mesh.0, file.0, "{input}");
    }
}
