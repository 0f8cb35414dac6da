//! The tour of the README, run: what it shows is what the program prints.
//!
//! Lines that begin with `$ ` in `console` blocks are run by a shell in a fresh folder with the
//! fixtures in it, one after the other. `UPDATE=1 cargo test -p lodc-cli --test cli readme` writes
//! the answers into the README.

use crate::support::{Folder, LODC};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Needs a graphics device: shown without an answer, not run.
const NOT_RUN: &str = "--gpu";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn run(folder: &Folder, command: &str) -> String {
    let programs = Path::new(LODC).parent().expect("the program lies in a folder");
    let path = std::env::join_paths(
        std::iter::once(programs.to_owned())
            .chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    )
    .expect("paths of programs");
    let output = Command::new("sh")
        .args(["-c", &format!("{{ {command}; }} 2>&1")])
        .current_dir(folder.path())
        .env("PATH", path)
        .output()
        .expect("a shell runs");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Seconds differ from run to run.
fn without_seconds(line: &str) -> &str {
    match line.rsplit_once(" in ") {
        Some((before, after)) if after.ends_with(" s") => before,
        _ => line,
    }
}

/// The text with the answer of every command in its `console` blocks replaced by that of a run.
fn answered(text: &str, folder: &Folder) -> String {
    let mut lines = text.lines().peekable();
    let mut out = String::new();
    let mut inside = false;
    while let Some(line) = lines.next() {
        inside = if line.starts_with("```") { line == "```console" } else { inside };
        out = out + line + "\n";
        let Some(command) = line.strip_prefix("$ ").filter(|_| inside) else { continue };
        let mut shown = Vec::new();
        while let Some(next) = lines.next_if(|l| !l.starts_with("$ ") && !l.starts_with("```")) {
            shown.push(next);
        }
        if command.contains(NOT_RUN) {
            continue;
        }
        let answer = run(folder, command);
        for (at, line) in answer.lines().enumerate() {
            let same = shown.get(at).filter(|s| without_seconds(s) == without_seconds(line));
            out = out + same.copied().unwrap_or(line) + "\n";
        }
    }
    out
}

#[test]
fn the_tour_is_true() {
    let folder = Folder::new();
    for name in ["machine_part.glb", "x_nan.obj"] {
        let bytes = fs::read(root().join("fixtures").join(name)).expect("a fixture");
        folder.file(&format!("fixtures/{name}"), bytes);
    }
    let path = root().join("README.md");
    let text = fs::read_to_string(&path).expect("a README");
    assert!(text.matches("\n$ lodc ").count() > 8, "the tour has gone");
    let true_text = answered(&text, &folder);
    if std::env::var_os("UPDATE").is_some() {
        fs::write(&path, &true_text).expect("the README can be written");
        return;
    }
    for (shown, printed) in text.lines().zip(true_text.lines()) {
        assert_eq!(shown, printed, "README.md shows something else: `just tour` writes it anew");
    }
    assert_eq!(text.lines().count(), true_text.lines().count(), "README.md: run `just tour`");
}

/// The library's examples are run as tests of package `lodc`; the README shows the same.
#[test]
fn the_library_examples_are_those_that_are_tested() {
    let read = |path: &str| fs::read_to_string(root().join(path)).expect("a file of the project");
    let examples = [
        ("crates/lodc/src/lib.rs", "use lodc::{Metric, Select};"),
        ("crates/lodc/src/gpu.rs", "use lodc::gpu::{Device, ResidentObject};"),
    ];
    for (file, first) in examples {
        let block = |text: &str| {
            let example = text.split(first).nth(1).expect("an example");
            example.split("```").next().unwrap_or_default().to_owned()
        };
        let comment = block(&read(file));
        let tested: Vec<&str> = comment
            .lines()
            .map(|line| line.trim_start_matches("//!").trim_start_matches(' ').trim_end())
            .filter(|line| !line.is_empty() && !line.starts_with("# "))
            .collect();
        let readme = block(&read("README.md"));
        let shown: Vec<&str> = readme.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
        assert_eq!(tested.iter().map(|l| l.trim()).collect::<Vec<_>>(), shown, "{file}");
    }
}
