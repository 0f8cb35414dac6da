//! The manifest as versions 1 and 2 wrote it: records without their lengths.

use super::manifest::{
    AttributeEntry, DocumentEntry, Manifest, ModelEntry, ObjectEntry, SubmeshEntry,
};
use super::record::Record;
use serde::Deserialize;

#[derive(Deserialize)]
pub(super) struct OldManifest {
    format: u8,
    content_hash: u128,
    document: DocumentEntry,
    objects: Vec<OldObject>,
}

#[derive(Deserialize)]
struct OldObject {
    name: String,
    world_scale: f64,
    document_mesh: u32,
    last_legal_lod: u32,
    topology_changes: u32,
    first_topology_change: Option<u32>,
    submeshes: Vec<SubmeshEntry>,
    attributes: Vec<AttributeEntry>,
    models: Vec<ModelEntry>,
}

impl From<OldManifest> for Manifest {
    fn from(old: OldManifest) -> Self {
        Self {
            format: old.format,
            content_hash: old.content_hash,
            document: old.document,
            objects: old.objects.into_iter().map(|o| Record(o.into())).collect(),
        }
    }
}

impl From<OldObject> for ObjectEntry {
    fn from(old: OldObject) -> Self {
        Self {
            name: old.name,
            world_scale: old.world_scale,
            document_mesh: old.document_mesh,
            last_legal_lod: old.last_legal_lod,
            topology_changes: old.topology_changes,
            first_topology_change: old.first_topology_change,
            submeshes: old.submeshes.into_iter().map(Record).collect(),
            attributes: old.attributes.into_iter().map(Record).collect(),
            models: old.models.into_iter().map(Record).collect(),
        }
    }
}
