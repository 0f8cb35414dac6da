//! Reading OBJ files and their material libraries.
//!
//! One file is one object. Its submeshes are its materials, in order of first use; the faces
//! without a material are a submesh of their own.

mod chunk;
#[cfg(test)]
mod faces_tests;
mod libraries;
mod lines;
mod notes;
mod number;
mod parse;
mod parsed;
#[cfg(test)]
mod tests;

use crate::faces::FaceFile;
use crate::options::ImportOptions;
use crate::{Assets, Fault, FormatError, ObjDocument, Scene, Source, SourceFormat, faces};
use xxhash_rust::xxh3::xxh3_128;

/// Reads an OBJ; `bytes` is the main file.
///
/// # Errors
/// See [`crate::import::import`].
pub(crate) fn import(
    bytes: Vec<u8>,
    assets: &mut Assets,
    options: &ImportOptions,
) -> Result<Scene, FormatError> {
    if bytes.is_empty() {
        return Err(FormatError::new(Fault::Malformed, "", "the file is empty"));
    }
    let content_hash = xxh3_128(&bytes);
    let mut parsed = parse::parse(&bytes, assets.limits())?;
    let mut offset = [0.0; 3];
    if faces::may_be_far(&parsed.faces.positions) {
        let exact = chunk::exact_positions(&bytes, assets.limits())?;
        if let Some(local) = faces::local(&exact) {
            (offset, parsed.faces.positions) = local;
        }
    }
    // The text is the largest thing in memory, and is not needed any more.
    drop(bytes);
    let libraries = std::mem::take(&mut parsed.libraries);
    let materials = libraries::Materials::read(&libraries, assets)?;

    let mut warnings = materials.warnings;
    let assembled = faces::assemble(&parsed.faces, content_hash as u64);
    notes::warn(&parsed, &assembled, &mut warnings);
    notes::warn_undefined(&assembled, &materials.list, &mut warnings);
    let name = parsed.faces.name(assets);
    drop(parsed);

    let source = Source { format: SourceFormat::Obj, content_hash };
    let document = ObjDocument { libraries, materials: materials.list, offset };
    faces::scene(FaceFile { assembled, name, source, document, warnings }, assets, options)
}
