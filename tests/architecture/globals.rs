//! Every static variable is listed in docs/ARCHITECTURE.md with its reason.

use super::{code, is_test, sources};
use std::collections::BTreeMap;

/// Every global: state that docs/ARCHITECTURE.md tells of, and two constants that are lent.
const STATICS: &[&str] = &[
    "ALLOCATOR",
    "CONSOLE",
    "COMMITTING",
    "SHARES",
    "START",
    "NEXT",
    "LEFTOVERS",
    "SESSIONS",
    "DECODER",
    "EMPTY",
    "NULL",
];

#[test]
fn global_state_is_that_of_the_page() {
    let mut found = BTreeMap::new();
    for (path, text) in sources().iter().filter(|(path, _)| !is_test(path)) {
        for line in code(text).lines().map(str::trim_start) {
            let line = line.trim_start_matches("pub ").trim_start_matches("pub(crate) ");
            if let Some((name, _)) = line.strip_prefix("static ").and_then(|l| l.split_once(':')) {
                found.insert(name.to_owned(), path.clone());
            }
        }
    }
    let unknown: Vec<_> = found.iter().filter(|(n, _)| !STATICS.contains(&n.as_str())).collect();
    assert!(unknown.is_empty(), "docs/ARCHITECTURE.md says nothing of {unknown:?}");
    let gone: Vec<_> = STATICS.iter().filter(|name| !found.contains_key(**name)).collect();
    assert!(gone.is_empty(), "{gone:?} are there no more");
}
