//! One vocabulary: the glossary has each term once, retired words are gone, comments begin well.

use super::scan::words;
use super::{read, root, sources, sources_of};
use std::collections::{BTreeMap, BTreeSet};

/// Openings of doc comments that say nothing about what an item is.
const OPENINGS: &[&str] = &["What", "Whether", "How", "Where", "Which"];

fn glossary() -> String {
    read(&root().join("docs/GLOSSARY.md"))
}

/// The rows of the tables under a heading, as their cells.
fn rows(text: &str, heading: &str) -> Vec<Vec<String>> {
    let section = text.split("\n## ").find(|s| s.starts_with(heading)).expect("a section");
    let cells = |line: &str| -> Vec<String> {
        line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()
    };
    let table = section.lines().filter(|line| line.starts_with("| "));
    table.map(cells).filter(|row| !row[0].starts_with("---")).skip(1).collect()
}

#[test]
fn terms_of_the_glossary_are_unique() {
    let text = glossary();
    let mut seen = BTreeSet::new();
    for heading in ["Terms"] {
        for row in rows(&text, heading) {
            assert!(row.len() == 2 && !row[1].is_empty(), "no meaning: {row:?}");
            for term in row[0].split(", ") {
                assert!(seen.insert(term.to_lowercase()), "{term} stands there twice");
            }
        }
    }
    assert!(seen.len() > 40, "only {} terms", seen.len());
    for row in rows(&text, "Retired words") {
        for word in row[0].split(", ") {
            assert!(!seen.contains(word.trim_matches('`')), "{word} is a term and retired");
        }
    }
}

#[test]
fn retired_words_are_gone() {
    let text = glossary();
    let retired: Vec<(String, String)> = rows(&text, "Retired words")
        .into_iter()
        .flat_map(|row| {
            let words: Vec<String> =
                row[0].split(", ").map(|w| w.trim_matches('`').to_owned()).collect();
            words.into_iter().map(move |word| (word, row[1].clone()))
        })
        .collect();
    assert!(retired.len() > 10);
    let mut found: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for (path, text) in sources_of(&["rs", "wgsl", "md", "py"]) {
        if path == "docs/GLOSSARY.md" || path.starts_with("tests/architecture") {
            continue;
        }
        let identifiers: BTreeSet<&str> = text.split(|c| !super::scan::is_word(c)).collect();
        let parts: BTreeSet<String> = words(&text).collect();
        for (word, _) in &retired {
            let typed = word.starts_with(char::is_uppercase) || word.contains('_');
            let there =
                if typed { identifiers.contains(word.as_str()) } else { parts.contains(word) };
            if there {
                found.entry(path.clone()).or_default().insert(word);
            }
        }
    }
    assert!(
        found.is_empty(),
        "retired words in files; docs/GLOSSARY.md says what to write instead: {found:#?}"
    );
}

#[test]
fn doc_comments_begin_with_what_an_item_is() {
    let mut left = Vec::new();
    for (path, text) in sources() {
        let mut before = "";
        for (at, line) in text.lines().map(str::trim_start).enumerate() {
            let opens = line.starts_with("/// ") && !before.starts_with("///");
            let first = line.trim_start_matches("/// ").split_whitespace().next().unwrap_or("");
            if opens && OPENINGS.contains(&first.trim_end_matches(',')) {
                left.push(format!("{path}:{}", at + 1));
            }
            before = line;
        }
    }
    assert!(left.is_empty(), "doc comments begin with one of {OPENINGS:?}: {left:#?}");
}
