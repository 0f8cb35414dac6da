//! The browser package: its WebAssembly and modules under node, its example in a browser.

use crate::support::{LODC, outside};
use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn the_package_gives_the_levels_of_the_program() {
    let Some(folder) = outside("LODC_WEB") else { return };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/web/test/package.mjs");
    let output = Command::new("node")
        .arg("--test")
        .arg(script)
        .env("LODC_WEB", folder)
        .env("LODC", LODC)
        .stdin(Stdio::null())
        .output()
        .expect("node is there if the package is");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("pass 4"), "not all tests ran: {text}");
}
