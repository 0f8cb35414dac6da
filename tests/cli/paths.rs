//! Nothing is read from outside the asset's own folder, and nothing is waited for.

use crate::support::{Folder, Run, grid};
use std::time::{Duration, Instant};

/// Ways out of a folder, as a file might spell them.
const WAYS_OUT: &[&str] = &[
    "../secret.bin",
    "../../etc/passwd",
    "sub/../../secret.bin",
    "%2e%2e/secret.bin",
    "..%2fsecret.bin",
    "..\\secret.bin",
    "/etc/passwd",
    "//etc/passwd",
    "file:///etc/passwd",
    "FILE:///etc/passwd",
    "http://127.0.0.1:9/x.bin",
    "https://127.0.0.1/x.bin",
    "ftp://127.0.0.1/x.bin",
    "link.bin",
    "pipe",
    "/dev/zero",
    "a%00b",
    "%FF",
    "C:\\secret.bin",
];

/// A folder with a secret beside it and a link and a pipe inside.
fn trap() -> Folder {
    let f = Folder::new();
    f.file("secret.bin", [7; 36]);
    f.file("asset/other.txt", "");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(f.join("secret.bin"), f.join("asset/link.bin")).expect("a link");
        let made = std::process::Command::new("mkfifo").arg(f.join("asset/pipe")).status().expect("mkfifo is there");
        assert!(made.success());
    }
    f
}

fn gltf(uri: &str) -> String {
    serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": uri}]
    })
    .to_string()
}

fn quickly(f: &Folder, args: &[&str]) -> Run {
    let start = Instant::now();
    let run = f.lodc(args);
    assert!(start.elapsed() < Duration::from_secs(5), "{args:?} took {:?}", start.elapsed());
    run
}

#[test]
fn no_buffer_leads_out_of_the_folder() {
    let f = trap();
    for way in WAYS_OUT {
        f.file("asset/a.gltf", gltf(way));
        let run = quickly(&f, &["build", "asset/a.gltf", "--depfile", "deps.d"]);
        let run = run.fails(3);
        assert!(!run.err.contains("root:"), "{way}: {}", run.err);
        assert!(!f.has("asset/a.lodc") && !f.join("deps.d").exists_with("secret"), "{way}");
    }
}

#[test]
fn a_folder_that_is_allowed_may_be_read() {
    let f = trap();
    f.file("asset/a.gltf", gltf("../secret.bin"));
    f.lodc(["build", "asset/a.gltf", "-q"]).ends(3);
    f.lodc(["build", "asset/a.gltf", "-q", "--allow-path", "."]).ends(0);
}

#[test]
fn no_material_library_leads_out_of_the_folder_and_a_missing_one_stops_nothing() {
    let f = trap();
    for way in WAYS_OUT.iter().copied().chain(["missing.mtl"]) {
        f.file("asset/a.obj", format!("mtllib {way}\nusemtl m\n{}", grid(2)));
        let run = quickly(&f, &["build", "asset/a.obj", "--depfile", "deps.d"]);
        assert!(matches!(run.status, Some(0 | 3)), "{way}: {}", run.err);
        assert!(!f.join("deps.d").exists_with("secret") && !f.join("deps.d").exists_with("passwd"), "{way}");
        assert!(!run.err.contains("root:"), "{way}: {}", run.err);
        assert!(run.err.contains("warning") || run.status == Some(3), "{way}: {}", run.err);
    }
}

#[test]
fn devices_pipes_and_folders_are_no_meshes() {
    let f = trap();
    for input in ["asset/pipe", "/dev/zero", "asset", "missing.obj"] {
        let run = quickly(&f, &["build", input, "-o", "x.lodc"]);
        assert_eq!(run.status, Some(3), "{input}: {}", run.err);
        assert_eq!(run.err.lines().count(), 1, "{input}: {}", run.err);
    }
}

#[test]
fn names_cannot_forge_messages() {
    let f = Folder::new();
    let run = f.lodc(["build", "a\nlodc: all is well\u{1b}[2J.obj"]).fails(3);
    assert!(!run.err.contains('\u{1b}'), "{}", run.err);
}

/// Whether a file exists and has this text in it.
trait ExistsWith {
    fn exists_with(&self, text: &str) -> bool;
}

impl ExistsWith for std::path::PathBuf {
    fn exists_with(&self, text: &str) -> bool {
        std::fs::read_to_string(self).is_ok_and(|all| all.contains(text))
    }
}
