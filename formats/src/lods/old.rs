//! The first block of version 1: everything but vertices and triangles (docs/STREAM.md, section
//! 12).

use super::object_header::{ObjectHeader, SystemEntry, vertex_layout};
use crate::lodc::manifest::{AttributeEntry, DocumentEntry, source_of};
use crate::{Document, Fault, FormatError, GltfDocument, ObjectInfo, Source, SubmeshInfo};
use lodc_mesh::{Attribute, Submesh};
use lodc_progressive::{MeshHeader, StreamVersion, text_codec};
use serde::Deserialize;

/// Bytes of the entries; a reader refuses more.
const LIMIT: usize = 256 << 20;

/// Everything but vertices and triangles.
#[derive(Clone, Debug)]
pub(super) struct Head {
    pub(super) source: Source,
    pub(super) document: Document,
    pub(super) objects: Vec<(ObjectInfo, ObjectHeader)>,
}

#[derive(Deserialize)]
struct HeadEntry {
    format: u8,
    content_hash: u128,
    document: DocumentEntry,
    objects: Vec<ObjectEntry>,
}

#[derive(Deserialize)]
struct ObjectEntry {
    name: String,
    world_scale: f64,
    document_mesh: u32,
    submeshes: Vec<SubmeshEntry>,
    attributes: Vec<AttributeEntry>,
    /// The number system of positions, then of each attribute.
    systems: Vec<SystemEntry>,
    vertices: u32,
    triangles: u32,
    steps: u32,
    strips: bool,
}

#[derive(Deserialize)]
struct SubmeshEntry {
    name: String,
    material: Option<String>,
    document_primitive: u32,
    attributes: Vec<u32>,
}

impl Head {
    /// Parses the payload of the first block.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let sections = Sections::split(bytes)?;
        let (entries, json) = sections.texts()?;
        let config = bincode::config::legacy().with_limit::<LIMIT>();
        let (entry, used) = bincode::serde::decode_from_slice::<HeadEntry, _>(&entries, config)
            .map_err(|e| malformed(&format!("cannot be decoded: {e}")))?;
        if used != entries.len() {
            return Err(malformed("has bytes left over"));
        }
        let document = document(entry.document, json, sections.blob)?;
        let source =
            source_of(entry.format, entry.content_hash).map_err(|what| malformed(&what))?;
        let objects: Vec<_> =
            entry.objects.into_iter().map(object_header).collect::<Result<_, _>>()?;
        Ok(Self { source, document, objects })
    }
}

const PLACE: &str = "head";

fn malformed(what: &str) -> FormatError {
    FormatError::new(Fault::Malformed, PLACE, what)
}

/// The parts of the first block's payload.
struct Sections<'a> {
    encoded: bool,
    /// Bytes of the entries, and of these and the JSON.
    entries: usize,
    text: usize,
    stored: &'a [u8],
    blob: &'a [u8],
}

impl<'a> Sections<'a> {
    fn split(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let short = || malformed("is too short for what it should hold");
        let (&[flag], mut rest) = bytes.split_first_chunk().ok_or_else(short)?;
        let mut numbers = [0; 3];
        for n in &mut numbers {
            let (four, more) = rest.split_first_chunk().ok_or_else(short)?;
            (*n, rest) = (u32::from_le_bytes(*four) as usize, more);
        }
        let [entries, text, stored] = numbers;
        let (stored, blob) = rest.split_at_checked(stored).ok_or_else(short)?;
        if flag > 1 || flag == 0 && stored.len() != text || entries > text {
            return Err(malformed("is stored in a way that is not known"));
        }
        Ok(Self { encoded: flag == 1, entries, text, stored, blob })
    }

    /// Returns the entries and the JSON.
    fn texts(&self) -> Result<(Vec<u8>, Vec<u8>), FormatError> {
        let mut entries = if self.encoded {
            text_codec::decode(self.stored, self.text)
                .ok_or_else(|| malformed("cannot be unpacked"))?
        } else {
            self.stored.to_vec()
        };
        let json = entries.split_off(self.entries);
        Ok((entries, json))
    }
}

fn document(entry: DocumentEntry, json: Vec<u8>, blob: &[u8]) -> Result<Document, FormatError> {
    match entry {
        DocumentEntry::Obj(obj) if json.is_empty() && blob.is_empty() => {
            Ok(Document::Obj(obj.into()))
        }
        DocumentEntry::Obj(_) => Err(malformed("has a glTF document for an OBJ")),
        DocumentEntry::Gltf => {
            let json =
                String::from_utf8(json).map_err(|_| malformed("has JSON that is not UTF-8"))?;
            Ok(Document::Gltf(GltfDocument { json, blob: blob.to_vec() }))
        }
    }
}

fn object_header(entry: ObjectEntry) -> Result<(ObjectInfo, ObjectHeader), FormatError> {
    if !(entry.world_scale.is_finite() && entry.world_scale > 0.0) {
        return Err(malformed("has an object whose scale is not a number above 0"));
    }
    let attributes: Vec<Attribute> = (entry.attributes.iter())
        .map(|a| a.described().filter(|a| (1..=16).contains(&a.components)))
        .collect::<Option<_>>()
        .ok_or_else(|| {
            malformed("has an attribute with components of an unknown type or number")
        })?;
    let layout = vertex_layout(entry.systems, &attributes)
        .ok_or_else(|| malformed("has a system of numbers that cannot be"))?;
    let submesh =
        |s: &SubmeshEntry| Submesh { attributes: s.attributes.clone(), ..Submesh::default() };
    let submeshes: Vec<Submesh> = entry.submeshes.iter().map(submesh).collect();
    if submeshes.is_empty() && entry.vertices > 0 {
        return Err(malformed("has vertices without a submesh"));
    }
    let info = |s: SubmeshEntry| SubmeshInfo {
        name: s.name,
        material: s.material,
        document_primitive: s.document_primitive,
    };
    let info = ObjectInfo {
        name: entry.name,
        submeshes: entry.submeshes.into_iter().map(info).collect(),
        world_scale: entry.world_scale,
        document_mesh: entry.document_mesh,
    };
    let mesh = MeshHeader {
        submeshes,
        attributes,
        layout,
        vertices: entry.vertices,
        triangles: entry.triangles,
        steps: entry.steps,
        strips: entry.strips,
        version: StreamVersion::One,
    };
    Ok((info, ObjectHeader { mesh, strips: None }))
}
