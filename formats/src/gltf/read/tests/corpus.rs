//! The folder of real models: everything valid imports with the counts its manifest states; what is
//! damaged ends in an error or is tolerated for a reason.

use crate::import::{ImportOptions, import};
use crate::testing::corpus;
use crate::{Fault, Scene};
use serde_json::{Map, Value};
use std::path::Path;

fn manifest(folder: &Path) -> Map<String, Value> {
    let text = std::fs::read(folder.join("manifest.json")).expect("the corpus has a manifest");
    match serde_json::from_slice(&text) {
        Ok(Value::Object(entries)) => {
            entries.into_iter().filter(|(name, _)| is_gltf(name)).collect()
        }
        _ => panic!("the manifest is an object"),
    }
}

fn is_gltf(name: &str) -> bool {
    [".gltf", ".glb"].iter().any(|end| name.ends_with(end))
}

/// Refused although valid: a version or extension that this package does not have.
const REFUSED: [&str; 2] = ["Compatibility_04.gltf", "Compatibility_05.gltf"];

/// Triangles with two corners at one position.
fn degenerate_triangles(scene: &Scene) -> u64 {
    let count = |w: &String| {
        let (count, what) = w.split_once(" triangle")?;
        what.contains("with two corners at one position").then_some(count)?.parse::<u64>().ok()
    };
    scene.warnings.iter().filter_map(count).sum()
}

#[test]
fn every_valid_model_imports_with_the_counts_of_the_manifest() {
    let Some(folder) = corpus() else { return };
    let mut checked = 0;
    for (name, entry) in
        manifest(&folder).iter().filter(|(name, _)| !name.starts_with("ugly/invalid/"))
    {
        let scene = import(&folder.join(name), &ImportOptions::default());
        if REFUSED.iter().any(|end| name.ends_with(end)) {
            assert_eq!(scene.map(|_| ()).map_err(|e| e.fault), Err(Fault::Unsupported), "{name}");
            continue;
        }
        let scene = scene.unwrap_or_else(|e| panic!("{name}: {e}"));
        let triangles: u64 = scene.objects.iter().map(|o| o.mesh.triangles().len() as u64).sum();
        let degenerate = degenerate_triangles(&scene);
        if !entry["modes"].as_array().is_some_and(|m| m.contains(&5.into())) {
            assert_eq!(Some(triangles + degenerate), entry["triangles"].as_u64(), "{name}");
        }
        if !entry["modes"].as_array().is_some_and(|m| m.iter().any(|m| m.as_u64() < Some(4))) {
            let meshes = entry["meshes"].as_u64();
            assert_eq!(Some(scene.objects.len() as u64), meshes, "{name}");
            let primitives: u64 =
                scene.objects.iter().map(|o| o.mesh.submeshes().len() as u64).sum();
            assert_eq!(Some(primitives), entry["primitives"].as_u64(), "{name}");
        }
        checked += 1;
    }
    assert!(checked > 80, "only {checked} models");
}

/// Validator codes of what makes geometry or the scene unreadable.
const FATAL: [&str; 16] = [
    "UNRESOLVED_REFERENCE",
    "BUFFER_VIEW_TOO_LONG",
    "ACCESSOR_TOO_LONG",
    "ACCESSOR_INDEX_OOB",
    "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
    "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT",
    "NODE_LOOP",
    "NODE_PARENT_OVERRIDE",
    "TYPE_MISMATCH",
    "GLB_INVALID_MAGIC",
    "GLB_INVALID_VERSION",
    "GLB_LENGTH_MISMATCH",
    "GLB_DUPLICATE_CHUNK",
    "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
    "GLB_UNEXPECTED_END_OF_CHUNK_HEADER",
    "IO_ERROR",
];

/// Valid, but its buffer has an address that is never read, or bytes that are nowhere although a
/// mesh needs them.
const UNREACHABLE: [&str; 3] =
    ["buffer/non_relative_uri.gltf", "root/named_objects.gltf", "root/unused_objects.gltf"];

#[test]
fn damaged_models_end_in_an_error_or_are_tolerated_for_a_reason() {
    let Some(folder) = corpus() else { return };
    let mut checked = 0;
    for (name, entry) in
        manifest(&folder).iter().filter(|(name, _)| name.starts_with("ugly/invalid/"))
    {
        let report =
            entry.pointer("/khronos_report/error_codes").or(entry.get("khronos_validator_errors"));
        let codes = report.and_then(Value::as_array).into_iter().flatten();
        let codes: Vec<&str> = codes.filter_map(Value::as_str).collect();
        let result = import(&folder.join(name), &ImportOptions::default());
        if let Some(code) = codes.iter().find(|c| FATAL.contains(c)) {
            let e = result.map(|_| ()).expect_err(&format!("{name} has {code}"));
            assert!(!e.problem.is_empty() && !e.to_string().contains('\n'), "{name}: {e}");
        } else if codes.is_empty()
            && report.is_some()
            && !UNREACHABLE.iter().any(|end| name.ends_with(end))
        {
            assert!(result.is_ok(), "{name}: {:?}", result.err());
        } else if let Err(e) = result {
            assert!(
                matches!(
                    e.fault,
                    Fault::Malformed | Fault::Unsupported | Fault::Forbidden | Fault::Unreadable
                ),
                "{name}: {e}"
            );
        }
        checked += 1;
    }
    assert!(checked > 100, "only {checked} models");
}
