//! Counts of an object's vertices, triangles, groups and records, for summaries and JSON.

use lodc_formats::ObjectInfo;
use lodc_mesh::Simplified;
use lodc_report::documents::ObjectCounts;

/// Counts of one object.
pub(crate) fn counts(info: &ObjectInfo, simplified: &Simplified) -> ObjectCounts {
    let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
    let (vertices, fakes) = (mesh.vertex_count() as u64, simplified.fakes() as u64);
    let parts = collapses.parts();
    ObjectCounts {
        name: info.name.clone(),
        vertices,
        referenced_vertices: vertices - fakes,
        triangles: mesh.triangles().len() as u64,
        submeshes: mesh.submeshes().len() as u64,
        fakes,
        records: u64::from(collapses.records()),
        steps: collapses.steps() as u64,
        last_legal_lod: parts.last_legal_lod.0,
        topology_changes: parts.topology_changes,
        first_topology_change: parts.first_topology_change.map(|lod| lod.0),
    }
}
