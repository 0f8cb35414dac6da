//! A program that uses lodc keeps its own behaviour: features of dependencies are unified over a
//! whole build, and none of ours may change what a host's code means.

use std::process::Command;

/// Those that add functions or types, and change nothing that is there. The others of `serde_json`
/// change what numbers and maps are: `arbitrary_precision`, `float_roundtrip`, `preserve_order`,
/// `unbounded_depth`.
const HARMLESS: [&str; 4] = ["default", "std", "alloc", "raw_value"];

#[test]
fn features_of_dependencies_do_not_change_the_code_of_a_host() {
    for features in ["read", "build,export,stream", "build,export,stream,gpu"] {
        let output = Command::new(env!("CARGO"))
            .args(["tree", "--package", "lodc", "--no-default-features", "--features", features])
            .args(["--offline", "--locked", "--edges", "normal"])
            .args(["--prefix", "none", "--format", "{p} {f}"])
            .current_dir(super::root())
            .output()
            .expect("cargo runs");
        let (errors, tree) = (output.stderr, output.stdout);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&errors));
        let tree = String::from_utf8(tree).expect("text");
        let lines = tree.lines().filter(|line| line.starts_with("serde_json "));
        let unified: Vec<&str> = lines.filter_map(|line| line.split(' ').nth(2)).collect();
        assert!(!unified.is_empty() || features == "read", "{tree}");
        let changed = unified.iter().flat_map(|list| list.split(','));
        let changed: Vec<&str> =
            changed.filter(|f| !f.is_empty() && !HARMLESS.contains(f)).collect();
        assert_eq!(changed, [""; 0], "with {features}");
    }
}
