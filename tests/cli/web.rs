//! The browser package: its modules under node, and as its users have it, in a browser.

use crate::support::{Folder, LODC, bounded, outside};
use serde_json::Value;
use std::path::Path;
use std::process::Stdio;

#[test]
fn the_package_gives_the_levels_of_the_program() {
    let Some(folder) = outside("LODC_WEB") else { return };
    node("package.mjs", &folder, 5);
}

#[test]
fn the_package_is_bundled_and_shows_models_and_streams_in_a_browser() {
    let Some(folder) = outside("LODC_WEB") else { return };
    node("browser.mjs", &folder, 22);
}

#[test]
fn the_package_refuses_damaged_files_or_reads_them() {
    let Some(package) = outside("LODC_WEB") else { return };
    let folder = Folder::new();
    let fixture = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/skinned_tube_u8.glb");
    folder.lodc(["build", fixture, "-o", "tube.lodc", "--models", "none", "-q"]).ends(0);
    folder.lodc(["pack", "tube.lodc", "-o", "tube.lods", "-q"]).ends(0);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/web/test/mutations.mjs");
    let output = bounded("node")
        .args([script.as_ref(), package.as_os_str()])
        .args(["400", "tube.lodc", "tube.lods"])
        .current_dir(folder.path())
        .output()
        .expect("node is there if the package is");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    let came: Value = serde_json::from_slice(&output.stdout).expect("it prints JSON");
    assert!(came["refused"].as_u64() > Some(400), "{came}");
}

/// Runs a script of `tests` tests. `LODC_WEB_TOOLS` names the packages that
/// they use.
fn node(script: &str, folder: &Path, tests: usize) {
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/web/test");
    let output = bounded("node")
        .arg("--test")
        .arg(scripts.join(script))
        .env("LODC_WEB", folder)
        .env("LODC", LODC)
        .stdin(Stdio::null())
        .output()
        .expect("node is there if the package is");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    assert!(text.contains(&format!("pass {tests}")), "not all tests ran: {text}");
}
