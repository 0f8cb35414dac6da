//! Packages from outside: each has its reason, and the fuzz targets and the plugin for Bevy,
//! workspaces of their own, are locked to the same ones.

use super::{DRAWING, read, root};
use std::collections::{BTreeMap, BTreeSet};

/// The versions of every package in a lock file.
fn locked(text: &str) -> BTreeMap<String, BTreeSet<String>> {
    let mut packages: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for block in text.split("[[package]]\n").skip(1) {
        let field = |name: &str| {
            let line = block.lines().find_map(|line| line.strip_prefix(name));
            line.and_then(|rest| rest.split('"').nth(1)).expect("a field of a package").to_owned()
        };
        packages.entry(field("name = ")).or_default().insert(field("version = "));
    }
    packages
}

#[test]
fn every_package_is_on_the_page_of_dependencies() {
    let page = read(&root().join("docs/design-notes/dependencies.md"));
    let used = DRAWING.iter().flat_map(|(_, used)| *used).chain(&["criterion"]);
    let from_outside = used.filter(|name| !name.starts_with("lodc"));
    let missing: BTreeSet<_> =
        from_outside.filter(|name| !page.contains(&format!("`{name}`"))).collect();
    assert!(missing.is_empty(), "docs/design-notes/dependencies.md says nothing of {missing:?}");
}

#[test]
fn other_workspaces_are_locked_to_what_the_readers_use() {
    let ours = locked(&read(&root().join("Cargo.lock")));
    let (_, used) = DRAWING.iter().find(|(folder, _)| *folder == "formats").expect("formats");
    for lock in ["formats/fuzz/Cargo.lock", "crates/bevy/Cargo.lock"] {
        let theirs = locked(&read(&root().join(lock)));
        for name in used.iter().filter(|name| !name.starts_with("lodc")) {
            let there = theirs.get(*name).unwrap_or_else(|| panic!("{lock} lacks {name}"));
            assert!(ours[*name].is_subset(there), "{lock} has {name} {there:?}");
        }
    }
}
