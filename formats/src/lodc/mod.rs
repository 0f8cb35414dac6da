//! The `.lodc` container (docs/FORMAT.md).

mod arrays;
mod container;
#[cfg(test)]
mod golden_tests;
#[cfg(test)]
mod hostile_tests;
mod left_out;
mod made_from;
pub(crate) mod manifest;
mod object;
mod record;
mod sections;
mod steps;
mod streams;
mod table;
#[cfg(test)]
mod tests;

use crate::{Document, Fault, FormatError, GltfDocument, ObjectInfo, Source};
use container::{Container, Writer};
use left_out::LeftOut;
use lodc_lod::AnyModel;
use lodc_mesh::Simplified;
pub use lodc_model::Layout;
use lodc_model::Model;
pub use made_from::MadeFrom;
use manifest::{DocumentEntry, Manifest};
pub use sections::{Section, sections};
use std::sync::Arc;
use streams::ZeroBudget;
use table::{SCENE, tag};

/// The version of the format.
pub const VERSION: u16 = 1;

/// A `.lodc` file in memory.
#[derive(Debug)]
pub struct LodFile {
    /// Origin of the scene.
    pub source: Source,
    /// Everything that is not a triangle mesh.
    pub document: Document,
    /// The objects.
    pub objects: Vec<LodObject>,
    /// Width of its indices.
    pub layout: Layout,
    /// Origin of its content, if whoever made it knew.
    pub made_from: Option<MadeFrom>,
    /// Parts that a reader left out because this version does not know them: one line for each, up
    /// to twenty. Empty in a file to be written; writing a file that was read leaves it out for
    /// good.
    pub left_out: Vec<String>,
}

/// One object of a `.lodc` file.
#[derive(Debug)]
pub struct LodObject {
    /// Its description.
    pub info: ObjectInfo,
    /// Its mesh in collapse order and the sequence.
    pub simplified: Arc<Simplified>,
    /// Its models, in the order of the file. Models that this version does not have are left out.
    pub models: Vec<AnyModel>,
}

/// The identity of a file: XXH3-128 of all its bytes.
#[must_use]
pub fn key(bytes: &[u8]) -> u128 {
    xxhash_rust::xxh3::xxh3_128(bytes)
}

/// Number of bytes of a file of some layout a model needs: positions, submeshes of vertices,
/// triangles, collapse sequence and its own arrays. Attribute streams, padding, the table and the
/// manifest are left out.
#[must_use]
pub fn stored_bytes(model: &AnyModel, layout: Layout) -> u64 {
    let own: usize = model.arrays(layout).iter().map(|a| a.bytes.len()).sum();
    object::geometry_bytes(model.simplified(), layout) + own as u64
}

/// Returns whether bytes claim to be a `.lodc` file.
#[must_use]
pub fn is_lodc(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89LODC")
}

/// Reads a container.
///
/// # Errors
/// If a checksum, count, offset or index is wrong, or the file needs a newer program.
pub fn read(bytes: &[u8]) -> Result<LodFile, FormatError> {
    let mut container = Container::read(bytes)?;
    let layout = container.layout();
    let manifest = Manifest::decode(container.take(tag::MANIFEST, SCENE, 0)?)?;
    let source = manifest.source()?;
    let document = match manifest.document {
        DocumentEntry::Obj(obj) => Document::Obj(obj.into()),
        DocumentEntry::Gltf => {
            let json = container.take(tag::DOCUMENT_JSON, SCENE, 0)?;
            let json = std::str::from_utf8(json).map_err(|e| {
                FormatError::new(Fault::Malformed, "section DJSN", format!("is not UTF-8: {e}"))
            })?;
            let blob = container.take(tag::DOCUMENT_BLOB, SCENE, 0)?.to_vec();
            Document::Gltf(GltfDocument { json: json.to_owned(), blob })
        }
    };
    let made_from = container.take_optional(tag::MADE_FROM, SCENE, 0).map(MadeFrom::read);
    let made_from = made_from.transpose()?;
    let mut zeros = ZeroBudget::of_file(bytes.len());
    let mut left_out = LeftOut::default();
    let objects = (0..)
        .zip(manifest.objects)
        .map(|(number, entry)| {
            object::read(&mut container, number, entry.0, &mut zeros, &mut left_out)
        })
        .collect::<Result<_, _>>()?;
    container.finish(&mut left_out)?;
    Ok(LodFile { source, document, objects, layout, made_from, left_out: left_out.into_lines() })
}

/// Returns what a file was made from, without reading its objects; none if the file does not say.
///
/// # Errors
/// If the file is damaged or needs a newer program.
pub fn made_from(bytes: &[u8]) -> Result<Option<MadeFrom>, FormatError> {
    let mut container = Container::read(bytes)?;
    container.take_optional(tag::MADE_FROM, SCENE, 0).map(MadeFrom::read).transpose()
}

/// Returns the bytes with the checksums that they should have as a file: for tests with crafted
/// files, and for fuzzing.
#[doc(hidden)]
#[must_use]
pub fn with_valid_checksums(bytes: &[u8]) -> Vec<u8> {
    table::with_valid_checksums(bytes)
}

/// Lays a container out. Equal contents give equal bytes.
#[must_use]
pub fn write(file: &LodFile) -> Vec<u8> {
    let mut zeros = ZeroBudget::default();
    let plan = |o: &LodObject| streams::plan(o.simplified.mesh(), file.layout, &mut zeros);
    let plans: Vec<_> = file.objects.iter().map(plan).collect();
    let manifest = Manifest::of(file, &plans).encode();
    let mut writer = Writer::default();
    writer.required(tag::MANIFEST, SCENE, 0, |out| out.extend_from_slice(&manifest));
    if let Document::Gltf(gltf) = &file.document {
        writer.required(tag::DOCUMENT_JSON, SCENE, 0, |out| {
            out.extend_from_slice(gltf.json.as_bytes());
        });
        writer.required(tag::DOCUMENT_BLOB, SCENE, 0, |out| out.extend_from_slice(&gltf.blob));
    }
    if let Some(made) = &file.made_from {
        writer.optional(tag::MADE_FROM, SCENE, 0, |out| out.extend_from_slice(&made.bytes()));
    }
    for ((number, object), plan) in (0..).zip(&file.objects).zip(&plans) {
        object::write(&mut writer, number, object, plan, file.layout);
    }
    writer.finish()
}
