//! The first block: everything but vertices and triangles (docs/STREAM.md, "The head").

use crate::lodc::manifest::{AttributeEntry, DocumentEntry, format_code, source_of};
use crate::{Document, Fault, FormatError, GltfDocument, Limits, ObjectInfo, Source, SubmeshInfo};
use lodc_mesh::{Attribute, Component, Submesh};
use lodc_progressive::{MeshHeader, NumberSystem, Stream, VertexLayout, text_codec};
use serde::{Deserialize, Serialize};

/// Bytes of the entries; a reader refuses more.
const LIMIT: usize = 256 << 20;

/// Everything but vertices and triangles.
#[derive(Clone, Debug)]
pub(super) struct Head {
    pub(super) source: Source,
    pub(super) document: Document,
    pub(super) objects: Vec<ObjectHeader>,
}

/// An object without vertices and triangles.
#[derive(Clone, Debug)]
pub(super) struct ObjectHeader {
    pub(super) info: ObjectInfo,
    pub(super) mesh: MeshHeader,
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
    /// The number system of positions, then of each attribute.
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
    /// Returns the payload of the first block; `None` if it would be too long.
    pub(super) fn to_bytes(&self) -> Option<Vec<u8>> {
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
        let encoded = text_codec::encode(&small);
        let is_encoded = encoded.is_some();
        let stored = encoded.unwrap_or_else(|| small.clone());
        let mut out = vec![u8::from(is_encoded)];
        for n in [entries, small.len(), stored.len()] {
            out.extend(u32::try_from(n).ok()?.to_le_bytes());
        }
        out.extend_from_slice(&stored);
        out.extend_from_slice(blob);
        (out.len() <= u32::MAX as usize).then_some(out)
    }

    /// Parses the payload of the first block.
    pub(super) fn parse(bytes: &[u8], limits: &Limits) -> Result<Self, FormatError> {
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
        let sum = |of: fn(&MeshHeader) -> u32| -> u64 {
            objects.iter().map(|o: &ObjectHeader| u64::from(of(&o.mesh))).sum()
        };
        if sum(|m| m.vertices) > limits.vertices || sum(|m| m.triangles) > limits.triangles {
            let what = "announces more vertices or triangles than the limit";
            return Err(FormatError::new(Fault::Limit, PLACE, what));
        }
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

fn object_entry(o: &ObjectHeader) -> ObjectEntry {
    let ObjectHeader { info, mesh } = o;
    let submeshes = info.submeshes.iter().zip(&mesh.submeshes).map(|(info, s)| SubmeshEntry {
        name: info.name.clone(),
        material: info.material.clone(),
        document_primitive: info.document_primitive,
        attributes: s.attributes.clone(),
    });
    ObjectEntry {
        name: info.name.clone(),
        world_scale: info.world_scale,
        document_mesh: info.document_mesh,
        submeshes: submeshes.collect(),
        attributes: mesh.attributes.iter().map(|a| AttributeEntry::of(a, true)).collect(),
        systems: mesh.layout.streams.iter().map(|s| system_entry(&mesh.layout, s)).collect(),
        vertices: mesh.vertices,
        triangles: mesh.triangles,
        steps: mesh.steps,
        strips: mesh.strips,
    }
}

fn system_entry(layout: &VertexLayout, stream: &Stream) -> SystemEntry {
    let systems = &layout.systems[stream.first..][..stream.channels];
    match systems[0] {
        NumberSystem::Float => SystemEntry::Float,
        NumberSystem::Decimal(n) => SystemEntry::Decimal(n),
        NumberSystem::Significant(n) => SystemEntry::Significant(n),
        NumberSystem::Integer => SystemEntry::Integer,
        NumberSystem::Grid { step, .. } => {
            let origin = |s: &NumberSystem| match s {
                NumberSystem::Grid { origin, .. } => *origin,
                _ => 0.0,
            };
            SystemEntry::Grid { origins: systems.iter().map(origin).collect(), step }
        }
    }
}

/// Returns the systems of a stream's channels; `None` if there is no such system.
fn stream_systems(
    entry: SystemEntry,
    channels: usize,
    component: Component,
) -> Option<Vec<NumberSystem>> {
    let system = match entry {
        SystemEntry::Float => NumberSystem::Float,
        SystemEntry::Decimal(n @ 0..=9) => NumberSystem::Decimal(n),
        SystemEntry::Significant(n @ 1..=7) => NumberSystem::Significant(n),
        SystemEntry::Integer => NumberSystem::Integer,
        SystemEntry::Grid { origins, step }
            if component == Component::F32 && origins.len() == channels && step > 0.0 =>
        {
            let grid = |origin| NumberSystem::Grid { origin, step };
            return Some(origins.into_iter().map(grid).collect());
        }
        _ => return None,
    };
    let is_integer = matches!(system, NumberSystem::Integer);
    (is_integer != (component == Component::F32)).then(|| vec![system; channels])
}

fn vertex_layout(
    entries: Vec<SystemEntry>,
    attributes: &[Attribute],
) -> Result<VertexLayout, FormatError> {
    let streams = VertexLayout::streams(attributes);
    if entries.len() != streams.len() {
        return Err(malformed("does not have one system of numbers for each stream"));
    }
    let components = std::iter::once(Component::F32).chain(attributes.iter().map(|a| a.component));
    let mut systems = Vec::new();
    for ((stream, component), entry) in streams.iter().zip(components).zip(entries) {
        let channels = stream_systems(entry, stream.channels, component);
        systems
            .extend(channels.ok_or_else(|| malformed("has a system of numbers that cannot be"))?);
    }
    Ok(VertexLayout { systems, streams })
}

fn object_header(entry: ObjectEntry) -> Result<ObjectHeader, FormatError> {
    if !(entry.world_scale.is_finite() && entry.world_scale > 0.0) {
        return Err(malformed("has an object whose scale is not a number above 0"));
    }
    let attributes: Vec<Attribute> = (entry.attributes.iter())
        .map(|a| a.described().filter(|a| (1..=16).contains(&a.components)))
        .collect::<Option<_>>()
        .ok_or_else(|| {
            malformed("has an attribute with components of an unknown type or number")
        })?;
    let layout = vertex_layout(entry.systems, &attributes)?;
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
    };
    Ok(ObjectHeader { info, mesh })
}
