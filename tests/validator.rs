//! The Khronos glTF validator judges what is exported: a file that was valid before is valid after.

#![expect(clippy::print_stderr, reason = "a test that is left out says so aloud")]

mod support;

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use support::{Folder, REFUSED, corpus, grid, manifest};

/// Runs the validator on GLB files; errors by file name. None, said aloud, if it is not installed.
fn errors(folder: &Folder, names: &[String]) -> Option<BTreeMap<String, Vec<String>>> {
    let Some(validator) = std::env::var_os("LODC_VALIDATOR") else {
        assert!(
            std::env::var_os("CI").is_none(),
            "LODC_VALIDATOR must name the glTF validator where CI is set"
        );
        eprintln!("SKIPPED: LODC_VALIDATOR does not name a gltf-validator (tests/run installs it)");
        return None;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/validate.js");
    folder.file("list.json", serde_json::to_string(names).expect("names are JSON"));
    let output = Command::new("node")
        .arg(script)
        .arg(validator)
        .arg("list.json")
        .current_dir(folder.path())
        .stderr(Stdio::inherit())
        .output()
        .expect("node is there if the validator is");
    assert!(output.status.success(), "the validator itself failed");
    Some(serde_json::from_slice(&output.stdout).expect("the script prints JSON"))
}

#[test]
fn exports_of_valid_gltf_files_are_valid_at_every_level() {
    let Some(corpus) = corpus() else { return };
    let folder = Folder::new();
    let mut names = Vec::new();
    for (path, facts) in manifest(&corpus) {
        // Images were left out of the corpus on purpose: that they cannot be opened is no fault of
        // the mesh.
        let only_images = |e: &Value| e == "IO_ERROR";
        let valid = facts["khronos_validator_errors"]
            .as_array()
            .is_some_and(|all| all.iter().all(only_images));
        let refused = REFUSED.iter().any(|(name, _)| *name == path);
        if !valid
            || refused
            || path.contains("/invalid/")
            || facts["triangles"].as_u64() > Some(200_000)
        {
            continue;
        }
        let input = corpus.join(&path);
        let run = folder.lodc([
            "build".as_ref(),
            input.as_os_str(),
            "-o".as_ref(),
            "m.lodc".as_ref(),
            "-q".as_ref(),
        ]);
        run.ends(0);
        for ratio in ["1", "0.25", "0.01"] {
            let name = format!("{}@{ratio}.glb", path.replace(['/', ' '], "_"));
            folder.lodc(["extract", "m.lodc", "--ratio", ratio, "-o", &name, "-q"]).ends(0);
            names.push(name);
        }
    }
    assert!(names.len() > 100, "only {} exports", names.len());
    let Some(errors) = errors(&folder, &names) else { return };
    let bad: Vec<_> =
        errors.iter().filter(|(_, e)| e.iter().any(|code| code != "IO_ERROR")).collect();
    assert!(bad.is_empty(), "{} of {} are invalid: {bad:#?}", bad.len(), names.len());
}

#[test]
fn an_obj_exported_as_glb_is_valid() {
    let folder = Folder::new();
    folder.file("c.mtl", "newmtl red\nKd 1 0 0\nd 0.5\n");
    folder.file("c.obj", format!("mtllib c.mtl\nusemtl red\n{}", grid(8)));
    folder.lodc(["build", "c.obj", "-q"]).ends(0);
    let names: Vec<String> = ["1", "0.2", "0"].iter().map(|r| format!("c{r}.glb")).collect();
    for (name, ratio) in names.iter().zip(["1", "0.2", "0"]) {
        folder.lodc(["extract", "c.lodc", "--ratio", ratio, "-o", name, "-q"]).ends(0);
    }
    let Some(errors) = errors(&folder, &names) else { return };
    assert!(errors.values().all(Vec::is_empty), "{errors:#?}");
}
