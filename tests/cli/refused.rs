//! Every committed file that must be refused is refused by the program: status, one line, no trace
//! of a panic.

use crate::support::{Folder, Run};
use std::path::{Path, PathBuf};

/// The committed files that must be refused, sorted.
fn malformed() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures");
    let entries = std::fs::read_dir(folder).expect("the folder can be listed");
    let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    paths.retain(|p| p.file_name().is_some_and(|n| n.to_string_lossy().starts_with("x_")));
    paths.sort();
    assert!(paths.len() >= 30, "only {} files", paths.len());
    paths
}

/// Refused, in one line that names the file and is not about this program.
fn refused(run: &Run, name: &str, what: &str) -> Result<(), String> {
    let lines: Vec<&str> = run.err.lines().collect();
    let fair = matches!(run.status, Some(3 | 5))
        && lines.len() == 1
        && lines[0].starts_with("lodc: ")
        && lines[0].contains(name)
        && !["panicked", "internal error", "RUST_BACKTRACE"]
            .iter()
            .any(|word| run.err.contains(word))
        && run.out.is_empty();
    if fair { Ok(()) } else { Err(format!("{what} {name}: {run:?}")) }
}

#[test]
fn an_empty_file_is_said_to_be_empty_whatever_its_name() {
    let f = Folder::new();
    for name in ["x.glb", "x.gltf", "x.obj", "x.ply", "x.stl"] {
        f.file(name, "");
        let run = f.lodc(["build", name, "-o", "x.lodc"]);
        assert_eq!(run.err.trim(), format!("lodc: {name}: the file is empty"));
        assert_eq!(run.status, Some(3));
    }
}

#[test]
fn every_malformed_fixture_ends_in_one_line_and_writes_nothing() {
    let f = Folder::new();
    let mut wrong = Vec::new();
    for path in malformed() {
        let name = path.file_name().expect("files have names").to_string_lossy().into_owned();
        let path = path.to_string_lossy();
        let commands: [&[&str]; 4] = [
            &["build", &path, "-o", "x.lodc"],
            &["info", &path],
            &["verify", &path],
            &["extract", &path, "--ratio", "0.5", "-o", "x.glb"],
        ];
        for args in commands {
            wrong.extend(refused(&f.lodc(args), &name, args[0]).err());
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(f.names().is_empty(), "{:?}", f.names());
}

#[test]
fn one_bad_input_does_not_stop_the_others() {
    let f = Folder::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures");
    let at = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let run = f.lodc([
        "build",
        &at("x_nan.obj"),
        &at("cube.obj"),
        &at("x_count_2_62.gltf"),
        "-o",
        "out/",
        "-q",
    ]);
    assert!(matches!(run.status, Some(3 | 5)), "{run:?}");
    assert_eq!(run.errors(), 2, "{}", run.err);
    assert!(f.has("out/cube.obj.lodc") && !f.has("out/x_nan.obj.lodc"));
}
