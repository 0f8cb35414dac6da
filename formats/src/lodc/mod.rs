//! The `.lodc` container, version 1 (docs/FORMAT.md).

use crate::{Document, FormatError, ObjectInfo, Source};
use lodc_mesh::Simplified;

/// A `.lodc` file in memory.
#[derive(Debug)]
pub struct LodFile {
    /// Where the scene came from.
    pub source: Source,
    /// Everything that is not a triangle mesh.
    pub document: Document,
    /// The objects.
    pub objects: Vec<LodObject>,
}

/// One object of a `.lodc` file.
#[derive(Debug)]
pub struct LodObject {
    /// Its description.
    pub info: ObjectInfo,
    /// Its mesh in collapse order and the sequence.
    pub simplified: Simplified,
    // models: Vec<lodc_lod::AnyModel>, once lodc-lod has it
}

/// Reads a container.
///
/// # Errors
/// If a checksum, count, offset or index is wrong.
pub fn read(_bytes: &[u8]) -> Result<LodFile, FormatError> {
    Err(FormatError::new(crate::Fault::Unsupported, "", "not yet"))
}

/// Lays a container out.
#[must_use]
pub fn write(_file: &LodFile) -> Vec<u8> {
    Vec::new()
}
