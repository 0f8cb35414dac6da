//! Writing results: whole or not at all, to a file or standard output; and dependency files.

use crate::exit::Outcome;
use crate::{console, interrupt};
use lodc_assets::AssetError;
use lodc_formats::{OutputFile, write_all};
use std::path::Path;

pub(crate) use lodc_assets::{Rule, Target, is_folder, is_stream, prepare, target};

/// Writes files, all or none; an interruption waits until they are in place.
///
/// # Errors
/// If one cannot be written.
pub(crate) fn commit(files: &[OutputFile]) -> Outcome<()> {
    // Copies of image files may have folders of their own.
    for folder in files.iter().skip(1).filter_map(|f| f.path.parent()) {
        if folder != Path::new("") && !folder.exists() {
            let made = std::fs::create_dir_all(folder);
            made.map_err(|e| {
                AssetError::Output(format!("{}: not written: {e}", folder.display()))
            })?;
        }
    }
    // Opening a pipe without a reader waits for ever, so there an interruption must get through;
    // it leaves nothing behind either, since pipes and devices are written to directly.
    let special = |f: &OutputFile| f.path.metadata().is_ok_and(|m| !m.is_file());
    let whole = (!files.iter().any(special)).then(interrupt::committing);
    write_all(files)?;
    whole.into_iter().for_each(|mut placed| *placed = true);
    Ok(())
}

/// Writes one result.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(target: &Target, bytes: Vec<u8>) -> Outcome<()> {
    match target {
        Target::Stdout => console::bytes(&bytes),
        Target::File(path) => commit(&[OutputFile { path: path.clone(), bytes }]),
    }
}

/// Writes a Make/Ninja dependency file.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write_depfile(path: &Path, rules: &[Rule]) -> Outcome<()> {
    rules.iter().try_for_each(Rule::check)?;
    let text: String = rules.iter().map(Rule::text).collect();
    write(&Target::File(path.to_owned()), text.into_bytes())
}
