//! Pages that others link to exist. Pages of measurements are short, have a command for every row,
//! and their plots are drawn from their rows.

use super::{read, root};
use std::fs;
use std::process::Command;

#[test]
fn the_page_of_benchmarks_is_short_and_names_files_that_are_there() {
    let text = read(&root().join("docs/BENCHMARKS.md"));
    let lines = text.lines().count();
    assert!(lines <= 250, "{lines} lines: rows belong into docs/benchmarks");
    let index = read(&root().join("docs/benchmarks/README.md"));
    for name in text.split('`').chain(index.split('`')).filter(|word| word.ends_with(".csv")) {
        assert!(root().join("docs/benchmarks").join(name).is_file(), "{name} is not there");
    }
}

#[test]
fn every_table_of_rows_names_its_command_and_has_all_cells() {
    let index = read(&root().join("docs/benchmarks/README.md"));
    let mut tables = 0;
    for entry in fs::read_dir(root().join("docs/benchmarks")).expect("a folder of rows") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|e| e != "csv") {
            continue;
        }
        let name = path.file_name().and_then(|n| n.to_str()).expect("a plain name");
        assert!(index.contains(&format!("`{name}`")), "docs/benchmarks/README.md lacks {name}");
        let text = read(&path);
        let mut lines = text.lines();
        assert!(lines.next().is_some_and(|l| l.starts_with("# ")), "{name} names no command");
        let columns = cells(lines.next().expect("names of columns"));
        for line in lines {
            assert_eq!(cells(line), columns, "{name}: {line}");
        }
        tables += 1;
    }
    assert!(tables > 10, "only {tables} tables");
}

/// Number of cells of a line; commas in quotes divide nothing.
fn cells(line: &str) -> usize {
    line.split('"').step_by(2).map(|part| part.matches(',').count()).sum::<usize>() + 1
}

#[test]
#[expect(clippy::print_stderr, reason = "a test that skips says so")]
fn plots_are_drawn_from_the_rows() {
    let script = root().join("tests/plots.py");
    match Command::new("python3").arg(script).arg("--check").output() {
        Ok(run) => assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr)),
        Err(e) => eprintln!("SKIPPED: no python3 to draw the plots with ({e})"),
    }
}

#[test]
fn documents_that_others_refer_to_are_there() {
    let root = root();
    let wanted = [
        "README.md",
        "CONTRIBUTING.md",
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "justfile",
        "deny.toml",
        "tests/run",
        "docs/ARCHITECTURE.md",
        "docs/ENGINE.md",
        "docs/FORMAT.md",
        "docs/GLOSSARY.md",
        "docs/THESIS.md",
        "docs/BENCHMARKS.md",
        "docs/RELEASE.md",
        "docs/CHANGELOG.md",
    ];
    let missing: Vec<&str> = wanted.into_iter().filter(|name| !root.join(name).is_file()).collect();
    assert!(missing.is_empty(), "{missing:?}");
    // Anything that is named in backticks as a file below docs/, crates/ or formats/ exists.
    for document in
        wanted.iter().filter(|name| name.ends_with(".md") && !name.ends_with("CHANGELOG.md"))
    {
        let text = read(&root.join(document));
        for name in text.split('`').skip(1).step_by(2) {
            let path = ["docs/", "crates/", "formats/", "cli/", "fixtures/", "tests/"]
                .iter()
                .any(|f| name.starts_with(f));
            let plain = !name.contains(|c: char| c.is_whitespace() || "*<>{}…:".contains(c));
            assert!(
                !path || !plain || root.join(name).exists(),
                "{document} names {name}, which is not there"
            );
        }
    }
}
