//! Wavefront OBJ and MTL.

use super::ImportOptions;
use crate::{Fault, FormatError, Scene};
use std::path::Path;

/// Reads an OBJ.
///
/// # Errors
/// See [`super::import`].
pub fn import(path: &Path, _options: &ImportOptions) -> Result<Scene, FormatError> {
    Err(FormatError::new(Fault::Unsupported, "", path.display().to_string()))
}
