//! The Khronos glTF validator judges what is exported: a file that was valid before is valid after.

use crate::support::{Folder, REFUSED, corpus, grid, manifest, outside, script};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The folder of the validator. None if it is not asked for.
fn validator() -> Option<PathBuf> {
    outside("LODC_VALIDATOR")
}

/// Runs the validator on glTF files; errors by file name. Files that they name are left out unless
/// `with_files`.
fn errors(
    validator: &Path,
    folder: &Folder,
    names: &[String],
    with_files: bool,
) -> BTreeMap<String, Vec<String>> {
    folder.file("list.json", serde_json::to_string(names).expect("names are JSON"));
    let args = [Some(validator.as_os_str()), Some("list.json".as_ref())];
    let args = args.into_iter().chain([with_files.then_some("--with-files".as_ref())]);
    let errors = script("validate.js", folder.path(), args.flatten());
    serde_json::from_value(errors).expect("lists of errors by file")
}

#[test]
fn exports_of_valid_gltf_files_are_valid_at_every_level() {
    let (Some(validator), Some(corpus)) = (validator(), corpus()) else { return };
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
            || facts["triangles"].as_u64() > Some(10_000)
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
            let extract = ["extract", "m.lodc", "--ratio", ratio, "-o", &name, "-q"];
            // One of the levels as it is by default.
            let plain = (ratio != "0.25").then_some("--no-refit");
            folder.lodc(extract.into_iter().chain(plain)).ends(0);
            names.push(name);
        }
        let bits = ["--quantize", "pos=14,normal=10,uv=12,color=8,weight=8"];
        let morphing = ["--geomorph=uv,tangent,color,joints"];
        let kinds = [("plain", &[][..]), ("quantised", &bits), ("morphing", &morphing)];
        for (kind, more) in kinds {
            let name = format!("{}@{kind}-chain.glb", path.replace(['/', ' '], "_"));
            folder.lodc(["chain", "m.lodc", "-o", &name, "-q"].iter().chain(more)).ends(0);
            names.push(name);
        }
    }
    assert!(names.len() > 100, "only {} exports", names.len());
    let errors = errors(&validator, &folder, &names, false);
    let bad: Vec<_> =
        errors.iter().filter(|(_, e)| e.iter().any(|code| code != "IO_ERROR")).collect();
    assert!(bad.is_empty(), "{} of {} are invalid: {bad:#?}", bad.len(), names.len());
}

#[test]
fn an_obj_exported_as_glb_is_valid() {
    let Some(validator) = validator() else { return };
    let folder = Folder::new();
    folder.file("c.mtl", "newmtl red\nKd 1 0 0\nd 0.5\n");
    folder.file("c.obj", format!("mtllib c.mtl\nusemtl red\n{}", grid(8)));
    folder.lodc(["build", "c.obj", "-o", "c.lodc", "-q"]).ends(0);
    let names: Vec<String> = ["1", "0.2", "0"].iter().map(|r| format!("c{r}.glb")).collect();
    for (name, ratio) in names.iter().zip(["1", "0.2", "0"]) {
        folder.lodc(["extract", "c.lodc", "--ratio", ratio, "-o", name, "-q"]).ends(0);
    }
    let errors = errors(&validator, &folder, &names, false);
    assert!(errors.values().all(Vec::is_empty), "{errors:#?}");
}

#[test]
fn textured_models_are_as_valid_in_another_folder() {
    let (Some(validator), Some(corpus)) = (validator(), corpus()) else { return };
    let folder = Folder::new();
    let mut pairs = Vec::new();
    for (path, facts) in manifest(&corpus) {
        let input = corpus.join(&path);
        let names_images = || {
            let text = std::fs::read_to_string(&input).unwrap_or_default();
            let json: Value = serde_json::from_str(&text).unwrap_or_default();
            json["images"].as_array().is_some_and(|all| all.iter().any(|i| i["uri"].is_string()))
        };
        let refused = REFUSED.iter().any(|(name, _)| *name == path);
        let large = facts["triangles"].as_u64() > Some(10_000);
        if !path.ends_with(".gltf") || refused || large || path.contains("/invalid/") {
            continue;
        }
        // Images that are not there stay as they are: what has some shows more.
        if !names_images() || path.contains("asset-generator") {
            continue;
        }
        let stem = path.replace(['/', ' '], "_");
        for format in ["gltf", "glb"] {
            let name = format!("{stem}/{format}/m.{format}");
            folder.file(&format!("{stem}/{format}/.keep"), "");
            let input = input.as_os_str().to_string_lossy().into_owned();
            for command in ["extract", "chain"] {
                let name = name.replace("/m.", &format!("/{command}."));
                let args = [command, &input, "-o", &name, "-q"];
                let selector: &[&str] =
                    if command == "extract" { &["--ratio", "0.5"] } else { &[] };
                folder.lodc(args.iter().chain(selector)).ends(0);
                pairs.push((input.clone(), name));
            }
        }
    }
    assert!(pairs.len() >= 4 * 5, "only {} exports", pairs.len());
    let names: Vec<String> = pairs.iter().flat_map(|(a, b)| [a.clone(), b.clone()]).collect();
    let errors = errors(&validator, &folder, &names, true);
    for (input, output) in &pairs {
        let new: Vec<_> = errors[output].iter().filter(|e| !errors[input].contains(e)).collect();
        assert!(new.is_empty(), "{output}: {new:?}");
    }
}
