//! The glossary has each term once; every file says what it is for, in lines that fit a screen.

use super::{read, root, sources, sources_of};
use std::collections::BTreeSet;

const MOST_COLUMNS: usize = 100;

#[test]
fn terms_of_the_glossary_are_unique() {
    let text = read(&root().join("docs/GLOSSARY.md"));
    let mut seen = BTreeSet::new();
    let table = text.lines().filter(|line| line.starts_with("| ")).skip(2);
    for row in table {
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [terms, meaning] = cells[..] else { panic!("not two cells: {row}") };
        assert!(!meaning.is_empty(), "no meaning: {row}");
        for term in terms.split(", ") {
            assert!(seen.insert(term.to_lowercase()), "{term} stands there twice");
        }
    }
    assert!(seen.len() > 40, "only {} terms", seen.len());
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
    for name in [".ci/lint", ".ci/run", "tests/run"] {
        let text = read(&root().join(name));
        assert!(text.lines().nth(1).is_some_and(|line| line.starts_with("# ")), "{name}");
    }
}
