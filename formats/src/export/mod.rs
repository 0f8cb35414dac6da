//! Writing one level of detail: one file or folder per format.

mod flatten;
mod gltf;
mod obj;
mod ply;

pub(crate) use gltf::gltf_without_missing;
pub use gltf::{ChainObject, ChainShape, LevelsObject, export_chain, export_levels};

use crate::{Document, FormatError, ObjectInfo, OutputFile};
use lodc_mesh::Mesh;
use std::path::Path;

/// A format that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// glTF 2.0, binary.
    Glb,
    /// glTF 2.0, JSON and one `.bin` beside it.
    Gltf,
    /// Wavefront OBJ and, where there are materials, an MTL beside it.
    Obj,
    /// Stanford PLY, binary little-endian.
    Ply,
}

/// One object at one level of detail.
#[derive(Clone, Copy, Debug)]
pub struct ExportObject<'a> {
    /// Its description.
    pub info: &'a ObjectInfo,
    /// Its triangles, with exactly the submeshes of `info` (some may be empty).
    pub mesh: &'a Mesh,
}

/// Makes the files of an export in memory; nothing is written.
///
/// # Errors
/// If the format cannot hold the scene.
pub fn export(
    path: &Path,
    format: ExportFormat,
    document: &Document,
    objects: &[ExportObject<'_>],
) -> Result<Vec<OutputFile>, FormatError> {
    match format {
        ExportFormat::Glb => gltf::export(path, true, document, objects),
        ExportFormat::Gltf => gltf::export(path, false, document, objects),
        ExportFormat::Obj => obj::export(path, document, objects),
        ExportFormat::Ply => ply::export(path, document, objects),
    }
}
