//! The first block: what there is besides growing meshes (docs/STREAM.md, section 3).

use super::layout::Layout;
use super::numbers::System;
use super::text;
use crate::lodc::manifest::{AttributeEntry, DocumentEntry, format_code, source_of};
use crate::{Document, Fault, FormatError, GltfDocument, Limits, ObjectInfo, Source, SubmeshInfo};
use lodc_mesh::{Attribute, Submesh};
use serde::{Deserialize, Serialize};

/// Bytes of the entries; a reader refuses more.
const LIMIT: usize = 256 << 20;

/// Everything but the growing meshes.
#[derive(Clone, Debug)]
pub(super) struct Head {
    pub(super) source: Source,
    pub(super) document: Document,
    pub(super) objects: Vec<Promise>,
}

/// What an object will be.
#[derive(Clone, Debug)]
pub(super) struct Promise {
    pub(super) info: ObjectInfo,
    /// Without triangles yet.
    pub(super) submeshes: Vec<Submesh>,
    /// Without bytes.
    pub(super) attributes: Vec<Attribute>,
    pub(super) layout: Layout,
    pub(super) vertices: u32,
    pub(super) triangles: u32,
    pub(super) steps: u32,
    /// Whether its strips are told.
    pub(super) strips: bool,
}

#[derive(Serialize, Deserialize)]
struct HeadEntry {
    format: u8,
    content_hash: u128,
    document: DocumentEntry,
    objects: Vec<ObjectEntry>,
}

#[derive(Serialize, Deserialize)]
struct ObjectEntry {
    name: String,
    world_scale: f64,
    document_mesh: u32,
    submeshes: Vec<SubmeshEntry>,
    attributes: Vec<AttributeEntry>,
    /// The system of positions, then of each attribute.
    systems: Vec<SystemEntry>,
    vertices: u32,
    triangles: u32,
    steps: u32,
    strips: bool,
}

#[derive(Serialize, Deserialize)]
struct SubmeshEntry {
    name: String,
    material: Option<String>,
    document_primitive: u32,
    attributes: Vec<u32>,
}

#[derive(Serialize, Deserialize)]
enum SystemEntry {
    Float,
    Decimal(u8),
    Significant(u8),
    Integer,
    Grid { origins: Vec<f32>, step: f32 },
}

impl Head {
    /// The payload of the first block. None if it would be too long.
    pub(super) fn bytes(&self) -> Option<Vec<u8>> {
        let entry = HeadEntry {
            format: format_code(self.source.format),
            content_hash: self.source.content_hash,
            document: DocumentEntry::of(&self.document),
            objects: self.objects.iter().map(object_entry).collect(),
        };
        let config = bincode::config::legacy();
        let mut small = bincode::serde::encode_to_vec(&entry, config)
            .expect("plain data can be written to memory");
        let entries = small.len();
        let mut blob: &[u8] = &[];
        if let Document::Gltf(gltf) = &self.document {
            small.extend_from_slice(gltf.json.as_bytes());
            blob = &gltf.blob;
        }
        let packed = text::pack(&small);
        let is_packed = packed.is_some();
        let stored = packed.unwrap_or_else(|| small.clone());
        let mut out = vec![u8::from(is_packed)];
        for n in [entries, small.len(), stored.len()] {
            out.extend(u32::try_from(n).ok()?.to_le_bytes());
        }
        out.extend_from_slice(&stored);
        out.extend_from_slice(blob);
        (out.len() <= u32::MAX as usize).then_some(out)
    }

    /// Reads a payload.
    pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Self, FormatError> {
        let malformed = |what: &str| FormatError::new(Fault::Malformed, "head", what);
        let cut = || malformed("is too short for what it should hold");
        let (&[packed], rest) = bytes.split_first_chunk().ok_or_else(cut)?;
        let mut numbers = [0; 3];
        let mut rest = rest;
        for n in &mut numbers {
            let (four, more) = rest.split_first_chunk().ok_or_else(cut)?;
            (*n, rest) = (u32::from_le_bytes(*four) as usize, more);
        }
        let [entries, small, stored] = numbers;
        let (stored, blob) = rest.split_at_checked(stored).ok_or_else(cut)?;
        let small = match packed {
            0 if stored.len() == small => stored.to_vec(),
            1 => text::unpack(stored, small).ok_or_else(|| malformed("cannot be unpacked"))?,
            _ => return Err(malformed("is packed in a way that is not known")),
        };
        let (entries, json) = small.split_at_checked(entries).ok_or_else(cut)?;
        let config = bincode::config::legacy().with_limit::<LIMIT>();
        let (entry, used) = bincode::serde::decode_from_slice::<HeadEntry, _>(entries, config)
            .map_err(|e| malformed(&format!("cannot be decoded: {e}")))?;
        if used != entries.len() {
            return Err(malformed("has bytes left over"));
        }
        let document = match entry.document {
            DocumentEntry::Obj(obj) if json.is_empty() && blob.is_empty() => {
                Document::Obj(obj.into())
            }
            DocumentEntry::Obj(_) => return Err(malformed("has a glTF document for an OBJ")),
            DocumentEntry::Gltf => {
                let json = std::str::from_utf8(json)
                    .map_err(|_| malformed("has JSON that is not UTF-8"))?;
                Document::Gltf(GltfDocument { json: json.to_owned(), blob: blob.to_vec() })
            }
        };
        let source =
            source_of(entry.format, entry.content_hash).map_err(|what| malformed(&what))?;
        let objects: Vec<_> = entry.objects.into_iter().map(promise).collect::<Result<_, _>>()?;
        let sum = |of: fn(&Promise) -> u32| objects.iter().map(|o| u64::from(of(o))).sum::<u64>();
        if sum(|o| o.vertices) > limits.vertices || sum(|o| o.triangles) > limits.triangles {
            return Err(FormatError::new(
                Fault::Limit,
                "head",
                "promises more vertices or triangles than the limit",
            ));
        }
        Ok(Self { source, document, objects })
    }
}

fn object_entry(o: &Promise) -> ObjectEntry {
    let submeshes = o.info.submeshes.iter().zip(&o.submeshes).map(|(info, s)| SubmeshEntry {
        name: info.name.clone(),
        material: info.material.clone(),
        document_primitive: info.document_primitive,
        attributes: s.attributes.clone(),
    });
    let systems = o.layout.streams.iter().map(|s| match o.layout.systems[s.first] {
        System::Float => SystemEntry::Float,
        System::Decimal(n) => SystemEntry::Decimal(n),
        System::Significant(n) => SystemEntry::Significant(n),
        System::Integer => SystemEntry::Integer,
        System::Grid { step, .. } => {
            let origin =
                |s: &System| if let System::Grid { origin, .. } = s { *origin } else { 0.0 };
            SystemEntry::Grid {
                origins: o.layout.systems[s.first..][..s.channels].iter().map(origin).collect(),
                step,
            }
        }
    });
    ObjectEntry {
        name: o.info.name.clone(),
        world_scale: o.info.world_scale,
        document_mesh: o.info.document_mesh,
        submeshes: submeshes.collect(),
        attributes: o.attributes.iter().map(|a| AttributeEntry::of(a, true)).collect(),
        systems: systems.collect(),
        vertices: o.vertices,
        triangles: o.triangles,
        steps: o.steps,
        strips: o.strips,
    }
}

fn promise(entry: ObjectEntry) -> Result<Promise, FormatError> {
    let wrong = |what: &str| FormatError::new(Fault::Malformed, "head", what);
    if !(entry.world_scale.is_finite() && entry.world_scale > 0.0) {
        return Err(wrong("has an object whose scale is not a number above 0"));
    }
    let attributes: Vec<Attribute> = (entry.attributes.iter())
        .map(|a| a.described().filter(|a| (1..=16).contains(&a.components)))
        .collect::<Option<_>>()
        .ok_or_else(|| wrong("has an attribute with components of an unknown type or number"))?;
    let streams = Layout::streams(&attributes);
    if entry.systems.len() != streams.len() {
        return Err(wrong("does not have one system of numbers for each stream"));
    }
    let mut systems = Vec::new();
    for ((i, stream), entry) in streams.iter().enumerate().zip(entry.systems) {
        let floats = i == 0 || attributes[i - 1].component == lodc_mesh::Component::F32;
        let all: Option<Vec<System>> = match entry {
            SystemEntry::Float => Some(vec![System::Float; stream.channels]),
            SystemEntry::Decimal(n @ 0..=9) => Some(vec![System::Decimal(n); stream.channels]),
            SystemEntry::Significant(n @ 1..=7) => {
                Some(vec![System::Significant(n); stream.channels])
            }
            SystemEntry::Integer => Some(vec![System::Integer; stream.channels]),
            SystemEntry::Grid { origins, step }
                if origins.len() == stream.channels && step > 0.0 =>
            {
                Some(origins.into_iter().map(|origin| System::Grid { origin, step }).collect())
            }
            _ => None,
        };
        let all = all.filter(|s| floats != matches!(s[0], System::Integer));
        systems.extend(all.ok_or_else(|| wrong("has a system of numbers that cannot be"))?);
    }
    let submesh =
        |s: &SubmeshEntry| Submesh { attributes: s.attributes.clone(), ..Submesh::default() };
    let submeshes: Vec<Submesh> = entry.submeshes.iter().map(submesh).collect();
    if submeshes.is_empty() && entry.vertices > 0 {
        return Err(wrong("has vertices without a submesh"));
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
    Ok(Promise {
        info,
        submeshes,
        attributes,
        layout: Layout { systems, streams },
        vertices: entry.vertices,
        triangles: entry.triangles,
        steps: entry.steps,
        strips: entry.strips,
    })
}
