//! The manifest of a `.lodc` file: the section with names, counts and settings of the scene, its
//! objects and their streams. Large arrays have sections of their own.
//!
//! These types are the file format: they are not those of the scene, so that the scene can change
//! and the file not. Fields are only ever added, at the end of a record.

use super::streams::Plan;
use super::{Bounds, LodFile, LodObject, StoredModel};
use crate::fields::{MAX_BYTES, Record, decode, to_bytes};
use crate::{Document, Fault, FormatError, ObjDocument, ObjMaterial, Source, SourceFormat};
use bincode::{Decode, Encode};
use lodc_mesh::{Attribute, Component, Semantic};

pub(super) const LOCATION: &str = "section MANI";

#[derive(Encode, Decode)]
pub(super) struct Manifest {
    pub(super) format: u8,
    pub(super) content_hash: u128,
    pub(super) document: DocumentEntry,
    pub(super) objects: Vec<Record<ObjectEntry>>,
}

#[derive(Encode, Decode)]
pub(crate) enum DocumentEntry {
    Obj(ObjEntry),
    Gltf,
    /// One with lines of points and lines, or whose mesh stands at an offset.
    RichObj(ObjEntry, Vec<String>, [f64; 3]),
}

#[derive(Encode, Decode)]
pub(crate) struct ObjEntry {
    libraries: Vec<String>,
    materials: Vec<(String, Vec<String>)>,
}

#[derive(Encode, Decode)]
pub(super) struct ObjectEntry {
    pub(super) name: String,
    pub(super) world_scale: f64,
    pub(super) document_mesh: u32,
    pub(super) last_legal_lod: u32,
    pub(super) topology_changes: u32,
    pub(super) first_topology_change: Option<u32>,
    pub(super) submeshes: Vec<Record<SubmeshEntry>>,
    pub(super) attributes: Vec<Record<AttributeEntry>>,
    pub(super) models: Vec<Record<ModelEntry>>,
    pub(super) bounds: Bounds,
}

#[derive(Encode, Decode)]
pub(super) struct SubmeshEntry {
    pub(super) name: String,
    pub(super) material: Option<String>,
    pub(super) document_primitive: u32,
    pub(super) triangles: u32,
    pub(super) attributes: Vec<u32>,
}

#[derive(Encode, Decode)]
pub(super) struct AttributeEntry {
    semantic: SemanticEntry,
    pub(super) morph_target: Option<u32>,
    pub(super) component: u8,
    pub(super) components: u8,
    pub(super) normalized: bool,
    /// True if the section has bytes for all vertices, not only for those of submeshes that have
    /// the stream.
    pub(super) full: bool,
}

#[derive(Encode, Decode)]
pub(super) enum SemanticEntry {
    Position,
    Normal,
    Tangent,
    TexCoord(u32),
    Color(u32),
    Joints(u32),
    Weights(u32),
    Custom(String),
}

#[derive(Encode, Decode)]
pub(super) struct ModelEntry {
    pub(super) name: String,
    /// Names of its arrays, one for each of the object's next `MODA` sections.
    pub(super) arrays: Vec<String>,
}

impl Manifest {
    /// Decodes the section; what follows the known fields belongs to later versions.
    pub(super) fn decode(bytes: &[u8]) -> Result<Self, FormatError> {
        if bytes.len() > MAX_BYTES {
            let problem = format!("has more than {MAX_BYTES} bytes");
            return Err(FormatError::new(Fault::Limit, LOCATION, problem));
        }
        let problem = "is truncated or has invalid values";
        decode(bytes).ok_or_else(|| FormatError::new(Fault::Malformed, LOCATION, problem))
    }

    /// Encodes the section: bincode's legacy encoding, fixed-width little-endian integers.
    pub(super) fn encode(&self) -> Vec<u8> {
        to_bytes(self)
    }

    pub(super) fn of<M>(file: &LodFile<M>, models: &[Vec<StoredModel>], plans: &[Plan]) -> Self {
        let objects = file.objects.iter().zip(models).zip(plans);
        let objects =
            objects.map(|((o, models), plan)| Record(object_entry(o, models, plan))).collect();
        let document = DocumentEntry::of(&file.document);
        Self {
            format: format_code(file.source.format),
            content_hash: file.source.content_hash,
            document,
            objects,
        }
    }

    pub(super) fn source(&self) -> Result<Source, FormatError> {
        source_of(self.format, self.content_hash)
            .map_err(|problem| FormatError::new(Fault::Malformed, LOCATION, problem))
    }
}

/// The number that stands for a source's format.
pub(crate) fn format_code(format: SourceFormat) -> u8 {
    match format {
        SourceFormat::Obj => 0,
        SourceFormat::Gltf => 1,
        SourceFormat::Glb => 2,
        SourceFormat::Ply => 3,
        SourceFormat::Stl => 4,
    }
}

/// The format of a source by its number.
pub(crate) fn source_format(number: u8) -> Result<SourceFormat, String> {
    match number {
        0 => Ok(SourceFormat::Obj),
        1 => Ok(SourceFormat::Gltf),
        2 => Ok(SourceFormat::Glb),
        3 => Ok(SourceFormat::Ply),
        4 => Ok(SourceFormat::Stl),
        n => Err(format!("names source format {n}, which is not known")),
    }
}

/// Types of components, in the order of their numbers.
const COMPONENTS: [Component; 6] =
    [Component::I8, Component::U8, Component::I16, Component::U16, Component::U32, Component::F32];

/// The number that stands for a type of components.
pub(crate) fn component_code(component: Component) -> u8 {
    let number = (0..).zip(COMPONENTS).find(|(_, c)| *c == component);
    number.expect("all types have one").0
}

/// The type of components by its number; none if it is not known.
pub(crate) fn component(number: u8) -> Option<Component> {
    COMPONENTS.get(usize::from(number)).copied()
}

/// Origin of a file, as the file states it.
pub(crate) fn source_of(format: u8, content_hash: u128) -> Result<Source, String> {
    Ok(Source { format: source_format(format)?, content_hash })
}

impl DocumentEntry {
    pub(crate) fn of(document: &Document) -> Self {
        match document {
            Document::Obj(obj) if obj.loose.is_empty() && obj.offset == [0.0; 3] => {
                Self::Obj(ObjEntry::of(obj))
            }
            Document::Obj(obj) => Self::RichObj(ObjEntry::of(obj), obj.loose.clone(), obj.offset),
            Document::Gltf(_) => Self::Gltf,
        }
    }

    /// The document of an OBJ; none for a glTF.
    ///
    /// # Errors
    /// If its offset is none: what is wrong.
    pub(crate) fn obj(self) -> Result<Option<ObjDocument>, &'static str> {
        match self {
            Self::Obj(obj) => Ok(Some(obj.into())),
            Self::RichObj(obj, loose, offset) if offset.iter().all(|c| c.is_finite()) => {
                Ok(Some(ObjDocument { loose, offset, ..obj.into() }))
            }
            Self::RichObj(..) => Err("has an offset that is not finite"),
            Self::Gltf => Ok(None),
        }
    }
}

impl ObjEntry {
    fn of(obj: &ObjDocument) -> Self {
        let material = |m: &ObjMaterial| (m.name.clone(), m.lines.clone());
        Self {
            libraries: obj.libraries.clone(),
            materials: obj.materials.iter().map(material).collect(),
        }
    }
}

fn object_entry<M>(object: &LodObject<M>, models: &[StoredModel], plan: &Plan) -> ObjectEntry {
    let (mesh, sequence) = (object.simplified.mesh(), object.simplified.collapses().parts());
    let submeshes = mesh.submeshes().iter().enumerate().map(|(i, s)| {
        let info = object.info.submeshes.get(i);
        Record(SubmeshEntry {
            name: info.map(|i| i.name.clone()).unwrap_or_default(),
            material: info.and_then(|i| i.material.clone()),
            document_primitive: info.map_or(i as u32, |i| i.document_primitive),
            triangles: s.triangle_count,
            attributes: s.attributes.clone(),
        })
    });
    let attributes = mesh.attributes().iter().zip(&plan.full);
    let attributes = attributes.map(|(a, &full)| Record(AttributeEntry::of(a, full)));
    let models = models.iter().map(|m| {
        let arrays = m.arrays.iter().map(|a| a.name.clone()).collect();
        Record(ModelEntry { name: m.name.clone(), arrays })
    });
    ObjectEntry {
        name: object.info.name.clone(),
        world_scale: object.info.world_scale,
        document_mesh: object.info.document_mesh,
        last_legal_lod: sequence.last_legal_lod.0,
        topology_changes: sequence.topology_changes,
        first_topology_change: sequence.first_topology_change.map(|lod| lod.0),
        submeshes: submeshes.collect(),
        attributes: attributes.collect(),
        models: models.collect(),
        bounds: Bounds::of(mesh.positions()),
    }
}

impl AttributeEntry {
    pub(super) fn of(a: &Attribute, full: bool) -> Self {
        Self {
            semantic: match &a.semantic {
                Semantic::Position => SemanticEntry::Position,
                Semantic::Normal => SemanticEntry::Normal,
                Semantic::Tangent => SemanticEntry::Tangent,
                Semantic::TexCoord(set) => SemanticEntry::TexCoord(*set),
                Semantic::Color(set) => SemanticEntry::Color(*set),
                Semantic::Joints(set) => SemanticEntry::Joints(*set),
                Semantic::Weights(set) => SemanticEntry::Weights(*set),
                Semantic::Custom(name) => SemanticEntry::Custom(name.clone()),
            },
            morph_target: a.morph_target,
            component: component_code(a.component),
            components: a.components,
            normalized: a.normalized,
            full,
        }
    }

    pub(super) fn semantic(&self) -> Semantic {
        match &self.semantic {
            SemanticEntry::Position => Semantic::Position,
            SemanticEntry::Normal => Semantic::Normal,
            SemanticEntry::Tangent => Semantic::Tangent,
            SemanticEntry::TexCoord(set) => Semantic::TexCoord(*set),
            SemanticEntry::Color(set) => Semantic::Color(*set),
            SemanticEntry::Joints(set) => Semantic::Joints(*set),
            SemanticEntry::Weights(set) => Semantic::Weights(*set),
            SemanticEntry::Custom(name) => Semantic::Custom(name.clone()),
        }
    }
}

impl From<ObjEntry> for ObjDocument {
    fn from(entry: ObjEntry) -> Self {
        let materials =
            entry.materials.into_iter().map(|(name, lines)| ObjMaterial { name, lines }).collect();
        Self { libraries: entry.libraries, materials, ..Self::default() }
    }
}
