//! Writing one level of detail: one file or folder per format.

mod flatten;
mod gltf;
mod obj;
mod ply;
mod precision;
mod provenance;

pub(crate) use flatten::parse as parse_json;
pub(crate) use gltf::gltf_without_missing;
pub use gltf::{ChainObject, ChainShape, LevelsObject, export_chain, export_levels};
pub use precision::Precision;
pub use provenance::{LevelFacts, Provenance};

use crate::textures::PlacedTextures;
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

/// Contents of an export besides the document and its objects. The default adds nothing.
#[derive(Clone, Debug, Default)]
pub struct Additions {
    /// The places of image files.
    pub textures: PlacedTextures,
    /// True to compress geometry by EXT_meshopt_compression.
    pub compress: bool,
    /// Bits that numbers keep (KHR_mesh_quantization); the default keeps all.
    pub precision: Precision,
    /// The origin to state.
    pub provenance: Option<Provenance>,
}

/// Makes the files of an export in memory; nothing is written. Image files keep their names.
///
/// # Errors
/// If the format cannot hold the scene.
pub fn export(
    path: &Path,
    format: ExportFormat,
    document: &Document,
    objects: &[ExportObject<'_>],
) -> Result<Vec<OutputFile>, FormatError> {
    export_with(path, format, document, objects, &Additions::default())
}

/// Makes the files of an export in memory, copies of image files included, the file that refers to
/// the others first.
///
/// # Errors
/// As [`export`].
pub fn export_with(
    path: &Path,
    format: ExportFormat,
    document: &Document,
    objects: &[ExportObject<'_>],
    additions: &Additions,
) -> Result<Vec<OutputFile>, FormatError> {
    let mut files = match format {
        ExportFormat::Glb => gltf::export(path, true, document, objects, additions),
        ExportFormat::Gltf => gltf::export(path, false, document, objects, additions),
        ExportFormat::Obj => obj::export(path, document, objects, additions),
        ExportFormat::Ply => ply::export(path, document, objects, additions.provenance.as_ref()),
    }?;
    files.extend(additions.textures.copies.iter().cloned());
    Ok(files)
}
