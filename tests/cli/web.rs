//! The browser package: its modules under node, and as its users have it, in a browser.

use crate::support::{LODC, bounded, outside};
use std::path::Path;
use std::process::Stdio;

#[test]
fn the_package_gives_the_levels_of_the_program() {
    let Some(folder) = outside("LODC_WEB") else { return };
    node("package.mjs", &folder, 3);
}

#[test]
fn the_package_is_bundled_and_shows_models_and_streams_in_a_browser() {
    let Some(folder) = outside("LODC_WEB") else { return };
    node("browser.mjs", &folder, 17);
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
