//! A program that uses lodc keeps its own behaviour: features of dependencies are unified over a
//! whole build, and none of ours may change what a host's code means.

use std::path::Path;
use std::process::Command;

const MANIFEST: &str = r#"
[package]
name = "host"
version = "0.0.0"
edition = "2024"

[dependencies]
lodc = { path = "ROOT/crates/lodc", features = ["build", "export", "stream"] }
lodc-formats = { path = "ROOT/formats" }
serde = { version = "1", features = ["derive"] }
serde_json = "1"

[workspace]

# As in the workspace, so that what it has compiled is not compiled again.
[profile.dev.package."*"]
opt-level = 0
"#;

const PROGRAM: &str = r##"
use serde::Deserialize;
use serde_json::{Value, json};

#[derive(Debug, PartialEq, Deserialize)]
#[serde(untagged)]
enum Size {
    Pixels(u32),
    Share(f64),
    Name(String),
}

#[derive(Debug, PartialEq, Deserialize)]
struct Style {
    #[serde(flatten)]
    size: Width,
}

#[derive(Debug, PartialEq, Deserialize)]
struct Width {
    width: f64,
}

fn main() {
    // lodc is linked, not only resolved.
    let refused = lodc_formats::import::import("missing.glb".as_ref(), &Default::default());
    assert!(refused.is_err());

    let sizes: Vec<Size> = serde_json::from_str(r#"[3, 0.5, "wide"]"#).expect("untagged numbers");
    assert_eq!(sizes, [Size::Pixels(3), Size::Share(0.5), Size::Name("wide".to_owned())]);
    let style: Style = serde_json::from_str(r#"{"width": 2.5}"#).expect("flattened numbers");
    assert_eq!(style.size.width, 2.5);

    let read: Value = serde_json::from_str("[1.0, 1.00, 1e2, 100.0]").expect("numbers");
    assert_eq!(read[0], read[1]);
    assert_eq!(read[2], read[3]);
    assert_eq!(read, json!([1.0, 1.0, 100.0, 100.0]));
    assert!(serde_json::from_str::<Value>("1e400").is_err());

    println!("{}", json!({ "b": 1, "a": 2 }));
}
"##;

#[test]
fn features_of_dependencies_do_not_change_the_code_of_a_host() {
    if !crate::support::asked("a build of a host program") {
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the root");
    let host = Path::new(env!("CARGO_TARGET_TMPDIR")).join("host");
    std::fs::create_dir_all(host.join("src")).expect("a folder");
    let manifest = MANIFEST.replace("ROOT", &root.to_string_lossy().replace('\\', "/"));
    std::fs::write(host.join("Cargo.toml"), manifest).expect("a manifest");
    std::fs::write(host.join("src/main.rs"), PROGRAM).expect("a program");
    // The versions that are there already: nothing is asked of a registry.
    std::fs::copy(root.join("Cargo.lock"), host.join("Cargo.lock")).expect("a lock file");
    let output = Command::new(env!("CARGO"))
        .args(["run", "--offline", "--quiet", "--target-dir"])
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join(".."))
        .current_dir(&host)
        .output()
        .expect("cargo runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), "{\"a\":2,\"b\":1}\n");
}
