//! The document of a stream: everything but the objects' meshes. Its bytes come in pieces between
//! blocks of steps: first the text, then buffer 0 of a glTF.

use super::head::Head;
use crate::fields::{Field, fields, to_bytes};
use crate::lodc::manifest::{DocumentEntry, format_code, source_of};
use crate::{Document, Fault, FormatError, GltfDocument, ObjectInfo, Source, SubmeshInfo};
use lodc_progressive::text_codec;

const PLACE: &str = "document";

/// Facts of an object's collapse sequence that its steps do not say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SequenceFacts {
    /// The last LOD reached without breaking a rule of legality.
    pub last_legal_lod: u32,
    /// Number of steps that changed the topology before the terminal phase.
    pub topology_changes: u32,
    /// The first LOD after such a step.
    pub first_topology_change: Option<u32>,
}
fields!(SequenceFacts { last_legal_lod, topology_changes, first_topology_change });

/// The document and the names of a scene.
#[derive(Clone, Debug)]
pub(super) struct Names {
    pub(super) source: Source,
    pub(super) document: Document,
    pub(super) objects: Vec<(ObjectInfo, SequenceFacts)>,
}

/// A document as a stream has it.
#[derive(Debug)]
pub(super) struct EncodedDocument<'a> {
    /// Bytes of the text, and the text as it is stored.
    pub(super) text_bytes: u32,
    pub(super) text: Vec<u8>,
    /// Buffer 0 of a glTF.
    pub(super) buffer: &'a [u8],
}

struct TextEntry {
    format: u8,
    content_hash: u128,
    document: DocumentEntry,
    objects: Vec<ObjectEntry>,
}
fields!(TextEntry { format, content_hash, document, objects });

struct ObjectEntry {
    name: String,
    world_scale: f64,
    document_mesh: u32,
    facts: SequenceFacts,
    submeshes: Vec<SubmeshEntry>,
}
fields!(ObjectEntry { name, world_scale, document_mesh, facts, submeshes });

struct SubmeshEntry {
    name: String,
    material: Option<String>,
    document_primitive: u32,
}
fields!(SubmeshEntry { name, material, document_primitive });

impl<'a> EncodedDocument<'a> {
    /// Encodes a document; `None` if its text would be too long.
    pub(super) fn new(
        source: &Source,
        document: &'a Document,
        objects: impl Iterator<Item = (&'a ObjectInfo, SequenceFacts)>,
    ) -> Option<Self> {
        let entry = TextEntry {
            format: format_code(source.format),
            content_hash: source.content_hash,
            document: DocumentEntry::of(document),
            objects: objects.map(|(info, facts)| object_entry(info, facts)).collect(),
        };
        let mut text = to_bytes(&entry);
        let mut buffer: &[u8] = &[];
        if let Document::Gltf(gltf) = document {
            text.extend_from_slice(gltf.json.as_bytes());
            buffer = &gltf.blob;
        }
        let text_bytes = u32::try_from(text.len()).ok()?;
        if let Some(coded) = text_codec::encode(&text).filter(|coded| coded.len() < text.len()) {
            text = coded;
        }
        Some(Self { text_bytes, text, buffer })
    }

    /// Returns the next bytes, at most `most`, after so many that were put already.
    pub(super) fn piece(&self, put: usize, most: usize) -> &[u8] {
        let (part, put) = match put.checked_sub(self.text.len()) {
            None => (&self.text[..], put),
            Some(put) => (self.buffer, put),
        };
        &part[put..part.len().min(put.saturating_add(most))]
    }
}

fn object_entry(info: &ObjectInfo, facts: SequenceFacts) -> ObjectEntry {
    let submesh = |s: &SubmeshInfo| SubmeshEntry {
        name: s.name.clone(),
        material: s.material.clone(),
        document_primitive: s.document_primitive,
    };
    ObjectEntry {
        name: info.name.clone(),
        world_scale: info.world_scale,
        document_mesh: info.document_mesh,
        facts,
        submeshes: info.submeshes.iter().map(submesh).collect(),
    }
}

/// Collects the pieces of a document.
#[derive(Debug, Default)]
pub(super) struct ReceivedDocument {
    text: Vec<u8>,
    pub(super) names: Option<Names>,
    /// Bytes so far, text and buffer.
    pub(super) bytes: u64,
}

impl ReceivedDocument {
    /// Returns whether everything that the head announces has come.
    pub(super) fn is_complete(&self, head: Head) -> bool {
        self.names.is_some() && self.bytes == u64::from(head.stored) + head.buffer
    }

    /// Takes the next piece. Returns whether the text became complete with it.
    pub(super) fn feed(&mut self, head: Head, piece: &[u8]) -> Result<bool, FormatError> {
        let total = u64::from(head.stored) + head.buffer;
        if total - self.bytes < piece.len() as u64 {
            return Err(malformed("is longer than the head says"));
        }
        self.bytes += piece.len() as u64;
        let missing = head.stored as usize - self.text.len();
        let (text, buffer) = piece.split_at(missing.min(piece.len()));
        self.text.extend_from_slice(text);
        let now_complete = self.names.is_none() && self.text.len() == head.stored as usize;
        if now_complete {
            self.names = Some(Names::parse(&self.text, head)?);
        }
        match self.names.as_mut().map(|n| &mut n.document) {
            Some(Document::Gltf(gltf)) => gltf.blob.extend_from_slice(buffer),
            _ if buffer.is_empty() => {}
            _ => return Err(malformed("has a buffer, but is no glTF")),
        }
        Ok(now_complete)
    }
}

impl Names {
    fn parse(stored: &[u8], head: Head) -> Result<Self, FormatError> {
        let decoded;
        let text = if stored.len() == head.text as usize {
            stored
        } else {
            decoded = text_codec::decode(stored, head.text as usize)
                .ok_or_else(|| malformed("cannot be decoded"))?;
            &decoded
        };
        let mut rest = text;
        let entry = TextEntry::take(&mut rest)
            .ok_or_else(|| malformed("ends too early or has what cannot be"))?;
        let source =
            source_of(entry.format, entry.content_hash).map_err(|what| malformed(&what))?;
        if source.format != head.format || entry.objects.len() != head.objects as usize {
            return Err(malformed("has another format or number of objects than the head"));
        }
        let document = document(entry.document, rest)?;
        let objects = entry.objects.into_iter().map(object_info).collect::<Result<_, _>>()?;
        Ok(Self { source, document, objects })
    }
}

fn document(entry: DocumentEntry, json: &[u8]) -> Result<Document, FormatError> {
    match entry {
        DocumentEntry::Obj(obj) if json.is_empty() => Ok(Document::Obj(obj.into())),
        DocumentEntry::Obj(_) => Err(malformed("has JSON for an OBJ")),
        DocumentEntry::Gltf => {
            let json = String::from_utf8(json.to_vec())
                .map_err(|_| malformed("has JSON that is not UTF-8"))?;
            Ok(Document::Gltf(GltfDocument { json, blob: Vec::new() }))
        }
    }
}

fn object_info(entry: ObjectEntry) -> Result<(ObjectInfo, SequenceFacts), FormatError> {
    if !(entry.world_scale.is_finite() && entry.world_scale > 0.0) {
        return Err(malformed("has an object whose scale is not a number above 0"));
    }
    let submesh = |s: SubmeshEntry| SubmeshInfo {
        name: s.name,
        material: s.material,
        document_primitive: s.document_primitive,
    };
    let info = ObjectInfo {
        name: entry.name,
        submeshes: entry.submeshes.into_iter().map(submesh).collect(),
        world_scale: entry.world_scale,
        document_mesh: entry.document_mesh,
        poses: vec![],
    };
    Ok((info, entry.facts))
}

fn malformed(what: &str) -> FormatError {
    FormatError::new(Fault::Malformed, PLACE, what)
}
