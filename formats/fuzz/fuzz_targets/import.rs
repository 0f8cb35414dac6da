//! Harness of the targets of external formats: a file in memory-backed storage, imported and
//! exported.

use lodc_formats::export::{ExportFormat, ExportObject, export};
use lodc_formats::import::{ImportOptions, import};
use std::path::Path;

/// Imports bytes as a file of that extension; what comes out must export.
pub(crate) fn import_and_export(bytes: &[u8], extension: &str) {
    let path = std::env::temp_dir().join(format!("lodc-fuzz-{}.{extension}", std::process::id()));
    std::fs::write(&path, bytes).expect("the temporary folder can be written to");
    let result = import(&path, &ImportOptions::default());
    let _ = std::fs::remove_file(&path);
    let Ok(scene) = result else { return };
    let objects: Vec<ExportObject<'_>> =
        scene.objects.iter().map(|o| ExportObject { info: &o.info, mesh: &o.mesh }).collect();
    for (format, name) in
        [(ExportFormat::Glb, "a.glb"), (ExportFormat::Obj, "a.obj"), (ExportFormat::Ply, "a.ply")]
    {
        let _ = export(Path::new(name), format, &scene.document, &objects);
    }
}
