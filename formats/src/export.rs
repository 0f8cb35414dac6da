//! Writing one level of detail, in any format.

pub use crate::gltf::write::rounding;
pub use crate::options::{Additions, ExportObject, Precision};
pub use crate::provenance::{GlideFacts, LevelFacts, Provenance, ScreenFacts};

use crate::flatten::{Placed, placed};
use crate::{Document, FormatError, Limits, ObjectInfo, OutputFile, gltf, obj, ply, scene_graph};
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
    // Texture coordinates of a glTF begin at the top.
    let top_left = matches!(document, Document::Gltf(_));
    let mut files = match format {
        ExportFormat::Glb | ExportFormat::Gltf => {
            gltf::write::export(path, format == ExportFormat::Glb, document, objects, additions)?
        }
        ExportFormat::Obj => {
            let library = match document {
                Document::Obj(obj) => obj::write::Library::new(obj, &additions.textures),
                Document::Gltf(gltf) => gltf::library(gltf, &additions.textures)?,
            };
            let placed = all_placed(document, objects)?;
            obj::write::export(path, &placed, top_left, &library, additions.provenance.as_ref())
        }
        ExportFormat::Ply => {
            let placed = all_placed(document, objects)?;
            ply::write::export(path, &placed, top_left, additions.provenance.as_ref())?
        }
    };
    files.extend(additions.textures.copies.iter().cloned());
    Ok(files)
}

/// The objects where the document shows them.
fn all_placed<'a>(
    document: &Document,
    objects: &[ExportObject<'a>],
) -> Result<Vec<Placed<'a>>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| o.info).collect();
    placed(&scene_graph(document, &infos, &Limits::DEFAULT)?, objects)
}
