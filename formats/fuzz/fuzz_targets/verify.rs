//! Bytes as a mesh file of any format: what is read, built and stored passes every check of
//! `verify`.

#![no_main]

use lodc::models::ModelKind;
use lodc_formats::import::{ImportOptions, import};
use lodc_formats::lodc::MadeFrom;
use lodc_formats::{FormatError, Limits};
use lodc_report::{CheckReport, check_errors_again, check_models, check_source};
use std::path::Path;

/// Largest number of triangles, and of vertices, of a mesh that is built. Chosen by hand: in the
/// time of one large mesh 50 small ones are built, which find more.
const MAX_SIZE: u64 = 600;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    // The first bytes tell the format; without a mark it is read as OBJ.
    let path = std::env::temp_dir().join(format!("lodc-fuzz-{}.obj", std::process::id()));
    std::fs::write(&path, bytes).expect("the temporary folder can be written to");
    let limits = Limits { vertices: MAX_SIZE, triangles: MAX_SIZE, ..Limits::DEFAULT };
    let options = ImportOptions { limits, ..ImportOptions::default() };
    if let Some(stored) = built(&path, &options) {
        let checks = checks(&stored, &path, &options).expect("what was built can be checked");
        let failed = checks.into_iter().find(|check| check.ok == Some(false));
        assert!(failed.is_none(), "{failed:#?}");
    }
});

/// The bytes of the file that is built; none if the mesh is refused.
fn built(path: &Path, options: &ImportOptions) -> Option<Vec<u8>> {
    let scene = import(path, options).ok()?;
    let built = lodc::build(path).import(options.clone()).models(&ModelKind::ALL).run().ok()?;
    let mut file = lodc::read(&built.to_bytes()).expect("what was written is read");
    file.made_from = MadeFrom::of(path, &scene.files, "", &[]);
    Some(lodc::write(&file))
}

fn checks(
    stored: &[u8],
    source: &Path,
    options: &ImportOptions,
) -> Result<Vec<CheckReport>, FormatError> {
    let file = lodc::read(stored)?;
    let mut all = check_models(&file.objects, &file.document, 1, &options.limits)?;
    all.extend(check_errors_again(&file, &options.limits)?);
    all.extend(check_source(&file, source, options)?);
    Ok(all)
}
