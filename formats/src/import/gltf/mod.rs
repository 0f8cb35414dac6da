//! glTF 2.0 and GLB.

use super::ImportOptions;
use crate::{Assets, Fault, FormatError, Scene};

/// Reads a glTF or GLB; `bytes` is the main file.
///
/// # Errors
/// See [`super::import`].
pub(crate) fn import(bytes: Vec<u8>, assets: &mut Assets, _options: &ImportOptions) -> Result<Scene, FormatError> {
    Err(FormatError::new(Fault::Unsupported, "", format!("{} {}", assets.main_name(), bytes.len())))
}
