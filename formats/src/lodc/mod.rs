//! The `.lodc` container (docs/FORMAT.md): a scene as its document, and for each object the full
//! mesh with the sequence of edge collapses that simplifies it, in checksummed sections.

mod arrays;
mod container;
#[cfg(test)]
mod golden_tests;
mod made_from;
#[cfg(test)]
mod malformed_tests;
pub(crate) mod manifest;
mod object;
mod overview;
mod poses;
mod sections;
mod skipped;
mod steps;
mod streams;
mod table;
#[cfg(test)]
mod tests;

use crate::{Document, Fault, FormatError, GltfDocument, ObjectInfo, Source};
use container::{Container, Writer};
use lodc_mesh::Simplified;
use lodc_model::Array;
pub use lodc_model::Layout;
pub use made_from::MadeFrom;
use manifest::Manifest;
use object::ObjectReader;
pub use overview::{Bounds, MAX_LEVELS, TableLevel, table_of_levels};
pub use poses::MAX_POSES;
pub use sections::{Section, sections};
use skipped::SkippedParts;
use std::sync::Arc;
use streams::OmittedZeros;
use table::{SCENE, tag};

/// The version of the format.
pub const VERSION: u16 = 1;

/// A `.lodc` file in memory. A model is a structure made from the collapse sequence that moves from
/// level to level at run time (Speed Strips, Masking Strips, Interactive Meshes). `M` is one:
/// [`StoredModel`] as the file has it, or whatever its arrays were turned into.
#[derive(Debug)]
pub struct LodFile<M = StoredModel> {
    /// The mesh file that the scene was read from.
    pub source: Source,
    /// Everything that is not a triangle mesh.
    pub document: Document,
    /// The objects.
    pub objects: Vec<LodObject<M>>,
    /// Width of its indices.
    pub layout: Layout,
    /// What decides its content, if that is known: hashes of its source and of the options.
    pub made_from: Option<MadeFrom>,
    /// Parts that a reader left out because this version does not know them: one line for each, up
    /// to twenty. Empty in a file to be written: a file that is read and written again loses such
    /// parts.
    pub left_out: Vec<String>,
}

/// One object of a `.lodc` file.
#[derive(Debug)]
pub struct LodObject<M = StoredModel> {
    /// Its description.
    pub info: ObjectInfo,
    /// Its mesh in collapse order and the sequence.
    pub simplified: Arc<Simplified>,
    /// Its models, in the order of the file. Models that a reader does not know are left out.
    pub models: Vec<M>,
}

/// A model as a file has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredModel {
    /// The name of its kind, unique within its object.
    pub name: String,
    /// Its arrays, in its own order.
    pub arrays: Vec<Array>,
}

impl StoredModel {
    /// Bytes of all arrays.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.arrays.iter().map(|array| array.bytes.len() as u64).sum()
    }
}

impl<M> LodFile<M> {
    /// Turns every model into something else.
    ///
    /// # Errors
    /// If `change` fails: its error, with the object as its location.
    pub fn with_models<N>(
        self,
        change: impl Fn(&Arc<Simplified>, M) -> Result<N, String>,
    ) -> Result<LodFile<N>, FormatError> {
        let Self { source, document, objects, layout, made_from, left_out } = self;
        let object = |(number, object): (usize, LodObject<M>)| {
            let LodObject { info, simplified, models } = object;
            let models = models.into_iter().map(|model| change(&simplified, model));
            let models = models.collect::<Result<_, _>>().map_err(|problem| {
                FormatError::new(Fault::Malformed, format!("object {number}"), problem)
            })?;
            Ok(LodObject { info, simplified, models })
        };
        let objects = objects.into_iter().enumerate().map(object).collect::<Result<_, _>>()?;
        Ok(LodFile { source, document, objects, layout, made_from, left_out })
    }
}

/// The identity of a file: XXH3-128 of all its bytes.
#[must_use]
pub fn key(bytes: &[u8]) -> u128 {
    xxhash_rust::xxh3::xxh3_128(bytes)
}

/// Number of bytes of a file of some layout that every model of an object needs: positions, the
/// submesh of each vertex, triangles and collapse sequence. Attribute streams, padding, the table
/// and the manifest are left out.
#[must_use]
pub fn geometry_bytes(simplified: &Simplified, layout: Layout) -> u64 {
    object::geometry_bytes(simplified, layout)
}

/// Returns whether bytes claim to be a `.lodc` file.
#[must_use]
pub fn is_lodc(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89LODC")
}

/// Reads a container, with models of the kinds in `model_kinds`; others are left out.
///
/// # Errors
/// If a checksum, count, offset or index is wrong, or the file needs a newer program.
pub fn read(bytes: &[u8], model_kinds: &[&str]) -> Result<LodFile, FormatError> {
    let mut container = Container::read(bytes)?;
    let layout = container.layout();
    let manifest = Manifest::decode(container.take(tag::MANIFEST, SCENE, 0)?)?;
    let source = manifest.source()?;
    let obj = manifest.document.obj();
    let obj = obj.map_err(|e| FormatError::new(Fault::Malformed, manifest::LOCATION, e))?;
    let document = match obj {
        Some(obj) => Document::Obj(obj),
        None => {
            let json = container.take(tag::DOCUMENT_JSON, SCENE, 0)?;
            let json = std::str::from_utf8(json).map_err(|e| {
                FormatError::new(Fault::Malformed, "section DJSN", format!("is not UTF-8: {e}"))
            })?;
            let blob = container.take(tag::DOCUMENT_BLOB, SCENE, 0)?.to_vec();
            Document::Gltf(GltfDocument::new(json.to_owned(), blob))
        }
    };
    let made_from = container.take_optional(tag::MADE_FROM, SCENE, 0).map(MadeFrom::read);
    let made_from = made_from.transpose()?;
    let (zeros, skipped) = (OmittedZeros::of_file(bytes.len()), SkippedParts::default());
    let mut reader = ObjectReader { container, model_kinds, zeros, skipped };
    let objects = (0..).zip(manifest.objects);
    let objects =
        objects.map(|(number, entry)| reader.object(number, entry.0)).collect::<Result<_, _>>()?;
    let ObjectReader { container, mut skipped, .. } = reader;
    container.finish(&mut skipped)?;
    Ok(LodFile { source, document, objects, layout, made_from, left_out: skipped.into_lines() })
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

/// Lays a container out. `store` lists the arrays of a model in a layout. Equal contents give equal
/// bytes.
#[must_use]
pub fn write<M>(file: &LodFile<M>, store: impl Fn(&M, Layout) -> StoredModel) -> Vec<u8> {
    // Bounded without the file's own bytes, which are not known yet: what is written can be read.
    let mut zeros = OmittedZeros::default();
    let plan = |o: &LodObject<M>| streams::plan(o.simplified.mesh(), file.layout, &mut zeros);
    let plans: Vec<_> = file.objects.iter().map(plan).collect();
    let stored = |o: &LodObject<M>| o.models.iter().map(|m| store(m, file.layout)).collect();
    let models: Vec<Vec<StoredModel>> = file.objects.iter().map(stored).collect();
    let manifest = Manifest::of(file, &models, &plans).encode();
    let mut writer = Writer::default();
    writer.required(tag::MANIFEST, SCENE, 0, |out| out.extend_from_slice(&manifest));
    for (number, object) in (0..).zip(&file.objects) {
        let levels = table_of_levels(&object.simplified);
        writer.optional(tag::LEVELS, number, 0, move |out| overview::put_levels(out, &levels));
    }
    if let Document::Gltf(gltf) = &file.document {
        writer.required(tag::DOCUMENT_JSON, SCENE, 0, |out| {
            out.extend_from_slice(gltf.json().as_bytes());
        });
        writer.required(tag::DOCUMENT_BLOB, SCENE, 0, |out| out.extend_from_slice(gltf.blob()));
    }
    if let Some(made) = &file.made_from {
        writer.optional(tag::MADE_FROM, SCENE, 0, |out| out.extend_from_slice(&made.bytes()));
    }
    for (((number, object), plan), models) in (0..).zip(&file.objects).zip(&plans).zip(models) {
        object::write(&mut writer, number, &object.simplified, models, plan, file.layout);
        if !object.info.poses.is_empty() {
            writer.optional(tag::POSES, number, 0, |out| poses::put(out, &object.info.poses));
        }
    }
    writer.finish()
}
