//! Files, functions and lines are short enough to be read.

use super::scan::{blanked, functions};
use super::{read, root, sources, sources_of};

const MOST_LINES_OF_A_FILE: usize = 400;

const MOST_LINES_OF_A_FUNCTION: usize = 60;

const MOST_COLUMNS: usize = 100;

#[test]
fn files_are_short() {
    let sources = sources();
    let long: Vec<String> = sources
        .iter()
        .map(|(path, text)| (path, text.lines().count()))
        .filter(|(_, lines)| *lines > MOST_LINES_OF_A_FILE)
        .map(|(path, lines)| format!("{path} has {lines} lines"))
        .collect();
    assert!(long.is_empty(), "{} files are too long: {long:#?}", long.len());
    let mut lengths: Vec<usize> = sources.values().map(|text| text.lines().count()).collect();
    lengths.sort_unstable();
    let median = lengths[lengths.len() / 2];
    assert!(median <= 160, "the median file has {median} lines");
}

#[test]
fn functions_are_short() {
    let mut long = Vec::new();
    for (path, text) in sources_of(&["rs", "wgsl"]) {
        for f in functions(&blanked(&text)) {
            if f.lines > MOST_LINES_OF_A_FUNCTION {
                long.push(format!("{path}:{}: {} has {} lines", f.line, f.name, f.lines));
            }
        }
    }
    assert!(long.is_empty(), "{} functions are too long: {long:#?}", long.len());
}

#[test]
fn lines_are_short() {
    let mut wide = Vec::new();
    for (path, text) in sources_of(&["rs", "wgsl", "py", "js"]) {
        let lines = text.lines().enumerate();
        let too_wide = lines.filter(|(_, line)| line.chars().count() > MOST_COLUMNS);
        wide.extend(too_wide.map(|(at, _)| format!("{path}:{}", at + 1)));
    }
    assert!(wide.is_empty(), "{} lines are too wide: {wide:#?}", wide.len());
}

#[test]
fn every_file_says_what_it_is_for() {
    // A module of tests beside the file it tests needs no words.
    let silent =
        |(path, text): &(String, String)| !text.starts_with("//! ") && !path.ends_with("tests.rs");
    let without: Vec<String> = sources().into_iter().filter(silent).map(|(path, _)| path).collect();
    assert!(without.is_empty(), "{without:#?}");
}

#[test]
fn scripts_begin_with_their_purpose() {
    for name in [".ci/lint", ".ci/run", "tests/run"] {
        let text = read(&root().join(name));
        assert!(text.lines().nth(1).is_some_and(|line| line.starts_with("# ")), "{name}");
    }
}
