//! The drawing in `docs/ARCHITECTURE.md` is true: arrows point down, and each package keeps to what
//! it owns.

#[path = "architecture/circles.rs"]
mod circles;
#[path = "architecture/drawing.rs"]
mod drawing;
#[path = "architecture/features.rs"]
mod features;
#[path = "architecture/globals.rs"]
mod globals;
#[path = "architecture/locks.rs"]
mod locks;
#[path = "architecture/pages.rs"]
mod pages;
#[path = "architecture/words.rs"]
mod words;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Every package with what it may use, lowest first. A package may only use packages above it in
/// this list.
const DRAWING: &[(&str, &[&str])] = &[
    ("crates/mesh", &["glam", "thiserror"]),
    ("crates/raster", &["glam"]),
    ("crates/scene", &["lodc-mesh", "glam", "rayon"]),
    ("crates/nearest", &["lodc-mesh", "glam", "rayon"]),
    (
        "crates/measure",
        &[
            "lodc-mesh",
            "lodc-nearest",
            "lodc-raster",
            "lodc-scene",
            "colorous",
            "glam",
            "rayon",
            "serde",
        ],
    ),
    ("crates/errors", &["lodc-mesh", "lodc-nearest", "glam", "rayon"]),
    ("crates/simplify", &["lodc-mesh", "lodc-raster", "glam", "prefetch-index", "rayon"]),
    ("crates/refit", &["lodc-mesh", "lodc-nearest", "glam", "rayon"]),
    ("crates/strip", &["lodc-mesh", "rayon", "thiserror"]),
    ("crates/progressive", &["lodc-mesh", "thiserror"]),
    ("crates/model", &["lodc-mesh", "thiserror"]),
    ("crates/verify", &["lodc-mesh", "lodc-model", "rayon", "thiserror"]),
    ("crates/plan", &["lodc-mesh", "lodc-strip", "thiserror"]),
    (
        "crates/lod",
        &[
            "lodc-mesh",
            "lodc-model",
            "lodc-plan",
            "lodc-strip",
            "lodc-verify",
            "rayon",
            "thiserror",
        ],
    ),
    (
        "crates/select",
        &["lodc-lod", "lodc-mesh", "lodc-raster", "lodc-scene", "glam", "rayon", "thiserror"],
    ),
    ("crates/gpu", &["lodc-plan", "bytemuck", "pollster", "thiserror", "wgpu"]),
    (
        "formats",
        &[
            "lodc-mesh",
            "lodc-model",
            "lodc-progressive",
            "lodc-scene",
            "bincode",
            "draco-core",
            "gltf",
            "hifijson",
            "indexmap",
            "png",
            "rayon",
            "serde",
            "serde_json",
            "serde-ply",
            "stl_io",
            "tobj",
            "xxhash-rust",
            "zune-jpeg",
        ],
    ),
    (
        "crates/lodc",
        &[
            "lodc-errors",
            "lodc-formats",
            "lodc-gpu",
            "lodc-lod",
            "lodc-measure",
            "lodc-mesh",
            "lodc-model",
            "lodc-refit",
            "lodc-scene",
            "lodc-select",
            "lodc-simplify",
            "lodc-strip",
            "bytemuck",
            "rayon",
            "thiserror",
        ],
    ),
    (
        "crates/report",
        &[
            "lodc",
            "lodc-formats",
            "lodc-lod",
            "lodc-measure",
            "lodc-mesh",
            "lodc-model",
            "lodc-scene",
            "lodc-select",
            "lodc-verify",
            "ab_glyph",
            "glam",
            "indexmap",
            "rayon",
            "serde",
        ],
    ),
    (
        "crates/lab",
        &[
            "lodc",
            "lodc-formats",
            "lodc-gpu",
            "lodc-lod",
            "lodc-measure",
            "lodc-mesh",
            "lodc-model",
            "lodc-report",
            "lodc-scene",
            "lodc-strip",
            "average",
            "criterion",
            "indexmap",
            "rayon",
            "serde",
            "serde_json",
            "thiserror",
        ],
    ),
    ("crates/web", &["lodc-formats", "lodc-mesh", "lodc-progressive", "lodc-scene", "lodc-select"]),
    (
        "cli",
        &[
            "lodc",
            "lodc-errors",
            "lodc-formats",
            "lodc-gpu",
            "lodc-lab",
            "lodc-lod",
            "lodc-measure",
            "lodc-mesh",
            "lodc-model",
            "lodc-plan",
            "lodc-refit",
            "lodc-report",
            "lodc-scene",
            "lodc-select",
            "lodc-simplify",
            "lodc-strip",
            "lodc-verify",
            "lodc-web",
            "clap",
            "clap_complete",
            "clap_mangen",
            "ctrlc",
            "globset",
            "indexmap",
            "indicatif",
            "mimalloc",
            "rayon",
            "rustix",
            "serde",
            "serde_json",
            "strsim",
            "toml",
            "walkdir",
        ],
    ),
    // Beside the drawing: shapes for tests. Its generator writes them with the project's own
    // exporters.
    ("fixtures", &["lodc-formats", "lodc-mesh", "lodc-model"]),
];

/// Tests, examples and benchmarks may also use these, sideways.
const FOR_TESTS: &[&str] = &[
    "lodc-fixtures",
    "lodc-formats",
    "lodc-lod",
    "lodc-measure",
    "lodc-mesh",
    "lodc-model",
    "lodc-simplify",
    "lodc-strip",
    "lodc-verify",
    "rayon",
    "xxhash-rust",
];

/// A word in code, and the only places that may use it.
const OWNED: &[(&str, &[&str])] = &[
    ("average::", &["crates/lab/"]),
    ("gltf::json", &["formats/"]),
    ("hifijson::", &["formats/"]),
    ("tobj::", &["formats/"]),
    ("bincode::", &["formats/"]),
    ("xxhash_rust::", &["formats/"]),
    ("png::", &["formats/"]),
    ("zune_jpeg::", &["formats/"]),
    ("wgpu::", &["crates/gpu/"]),
    // Lists and configurations are read where assets are chosen.
    ("std::fs", &["formats/", "crates/lodc/", "cli/"]),
    ("std::net", &[]),
    ("clap::", &["cli/"]),
    ("indicatif::", &["cli/"]),
    ("println!", &["cli/"]),
    ("process::exit", &["cli/"]),
    // The lab measures.
    ("Instant::now", &["crates/lab/", "cli/"]),
    // No time is ever written, nor decides what is up to date.
    ("SystemTime", &["cli/", "formats/src/write"]),
    // For looking up only: what is written never follows a map's order.
    ("HashMap", &["formats/src/obj/write.rs", "formats/src/colours.rs"]),
    ("HashSet", &[]),
    ("mul_add", &[]),
];

/// Names of models, and where they may stand: the closed list, the models themselves, and options
/// of the program.
const MODELS: &[&str] = &["Interactive", "SpeedStrips", "MaskingStrips", "Speed,", "Masking,"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the package lies in the workspace")
        .to_owned()
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The names in the sections of a manifest that start with `section`.
fn dependencies(manifest: &str, section: &str) -> Vec<String> {
    let mut inside = false;
    let mut names = Vec::new();
    for line in manifest.lines().map(str::trim) {
        if let Some(header) = line.strip_prefix('[') {
            assert!(
                !header.starts_with("target."),
                "a dependency for one system only is not in the drawing: {line}"
            );
            inside = header.trim_end_matches(']') == section;
        } else if inside
            && !line.starts_with('#')
            && let Some((name, _)) = line.split_once(['.', '=', ' '])
        {
            names.push(name.to_owned());
        }
    }
    names
}

/// All Rust files of the workspace's packages and tests, by their path from the root.
fn sources() -> BTreeMap<String, String> {
    sources_of(&["rs"])
}

/// All files with one of these extensions, by their path from the root.
fn sources_of(extensions: &[&str]) -> BTreeMap<String, String> {
    let root = root();
    let mut found = BTreeMap::new();
    let mut folders: Vec<PathBuf> =
        ["crates", "cli", "formats", "fixtures", "tests", "docs"].map(|f| root.join(f)).to_vec();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("folders of the workspace can be listed") {
            let path = entry.expect("entries can be read").path();
            let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default().to_owned();
            if path.is_dir() && name != "target" && name != "node_modules" {
                folders.push(path);
            } else if has_extension(&path, extensions) {
                let name = path
                    .strip_prefix(&root)
                    .expect("below the root")
                    .to_string_lossy()
                    .replace('\\', "/");
                found.insert(name, read(&path));
            }
        }
    }
    assert!(found.len() > 20, "only {} files: the wrong folder?", found.len());
    found
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().and_then(|e| e.to_str()).is_some_and(|e| extensions.contains(&e))
}

fn is_test(path: &str) -> bool {
    path.starts_with("tests/")
        || ["/tests/", "/benches/", "/examples/", "/fuzz/", "fixtures/"]
            .iter()
            .any(|part| path.contains(part))
        || ["tests.rs", "testing.rs"].iter().any(|end| path.ends_with(end))
}

/// The code of a file: without comments, and without the tests at its end.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let without = |line: &str| line.split("//").next().unwrap_or_default().to_owned();
    text.lines().map(without).collect::<Vec<_>>().join("\n")
}

#[test]
fn dependencies_are_those_of_the_drawing() {
    let root = root();
    let members = read(&root.join("Cargo.toml"));
    let members = members
        .split_once("members = [")
        .and_then(|(_, rest)| rest.split_once(']'))
        .expect("members")
        .0;
    let members: Vec<&str> =
        members.split(',').map(|m| m.trim().trim_matches('"')).filter(|m| !m.is_empty()).collect();
    let drawn: Vec<&str> = DRAWING.iter().map(|(folder, _)| *folder).collect();
    for member in &members {
        assert!(drawn.contains(member), "{member} is not in the drawing");
    }
    let mut lower: Vec<String> = Vec::new();
    for (folder, allowed) in DRAWING.iter().filter(|(folder, _)| members.contains(folder)) {
        let manifest = read(&root.join(folder).join("Cargo.toml"));
        for name in dependencies(&manifest, "dependencies")
            .iter()
            .chain(&dependencies(&manifest, "build-dependencies"))
        {
            assert!(
                allowed.contains(&name.as_str()),
                "{folder} uses {name}, which the drawing does not allow"
            );
            assert!(
                !name.starts_with("lodc-") || lower.contains(name),
                "{folder} uses {name}, which is not below it"
            );
        }
        for name in dependencies(&manifest, "dev-dependencies") {
            let known = FOR_TESTS.contains(&name.as_str()) || allowed.contains(&name.as_str());
            assert!(known, "tests of {folder} use {name}");
        }
        let name = manifest
            .split_once("name = \"")
            .and_then(|(_, rest)| rest.split_once('"'))
            .expect("a name")
            .0;
        lower.push(name.to_owned());
    }
}

#[test]
fn every_version_stands_in_one_place() {
    let root = root();
    let workspace = read(&root.join("Cargo.toml"));
    let listed = workspace
        .split_once("[workspace.dependencies]")
        .and_then(|(_, rest)| rest.split_once("[workspace.lints"));
    for line in listed
        .expect("a list of dependencies")
        .0
        .lines()
        .filter(|l| l.contains('=') && !l.starts_with('#'))
    {
        // Hosts of the library choose among later ones; Cargo.lock pins those of the program.
        assert!(!line.contains("\"="), "pinned: {line}");
    }
    for (folder, _) in DRAWING {
        let Ok(manifest) = std::fs::read_to_string(root.join(folder).join("Cargo.toml")) else {
            continue;
        };
        assert!(
            manifest.contains("[lints]\nworkspace = true"),
            "{folder} does not take the workspace's lints"
        );
        let sections = manifest.split("dependencies]").skip(1);
        for line in sections.flat_map(|s| s.split("\n[").next().unwrap_or_default().lines()) {
            let silent = line.is_empty() || line.starts_with('#');
            assert!(
                silent || line.contains("workspace = true") || line.contains("{ path = "),
                "{folder} states a version itself: {line}"
            );
        }
    }
}

#[test]
fn what_a_package_owns_is_used_nowhere_else() {
    let mut offenders = Vec::new();
    for (path, text) in sources().iter().filter(|(path, _)| !is_test(path)) {
        let code = code(text);
        for (word, owners) in OWNED {
            if code.contains(word) && !owners.iter().any(|owner| path.starts_with(owner)) {
                offenders.push(format!("{path} uses {word}"));
            }
        }
    }
    assert!(offenders.is_empty(), "{offenders:#?}");
}

#[test]
fn models_are_named_in_one_list_and_in_their_own_folders() {
    let may = |path: &str| path.starts_with("crates/lod/src/") || path.starts_with("cli/src/");
    let mut offenders = Vec::new();
    for (path, text) in sources().iter().filter(|(path, _)| !is_test(path) && !may(path)) {
        offenders.extend(
            MODELS.iter().filter(|m| code(text).contains(**m)).map(|m| format!("{path} names {m}")),
        );
    }
    for (path, text) in
        sources().iter().filter(|(path, _)| path.starts_with("crates/lod/src/") && !is_test(path))
    {
        let own = path.contains("/interactive/")
            || path.ends_with("/any.rs")
            || path.ends_with("/src/lib.rs");
        if !own && code(text).contains("Interactive") {
            offenders.push(format!("{path} names a model"));
        }
    }
    assert!(offenders.is_empty(), "{offenders:#?}");
}
