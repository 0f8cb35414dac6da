//! A complete object as a simplified mesh again.

use super::document::SequenceFacts;
use crate::{Fault, FormatError};
use lodc_mesh::{
    CollapseSequence, Lod, Mesh, PositionIds, SequenceParts, Simplified, removal_lods,
};
use lodc_progressive::MeshDecoder;
use lodc_strip::StripSet;
use std::fmt::Display;

/// A simplified mesh that came as a stream.
#[derive(Clone, Debug)]
pub struct Rebuilt {
    /// The mesh and its sequence. Errors are 0: they are to be measured.
    pub simplified: Simplified,
    /// Triangles left out because quantising has put two of their corners at one position.
    pub degenerate_triangles: usize,
}

/// Returns the mesh and the collapse sequence of a complete object.
pub(super) fn rebuild(decoder: &MeshDecoder, facts: SequenceFacts) -> Result<Rebuilt, FormatError> {
    let mut parts = decoder.mesh_parts();
    let degenerate_triangles = parts.drop_degenerate();
    let mesh = Mesh::try_from(parts).map_err(malformed)?;
    let parts = sequence_parts(decoder, facts, mesh.triangles().len() as u32);
    let sequence = CollapseSequence::try_from(parts).map_err(malformed)?;
    let simplified = Simplified::new(mesh, sequence).map_err(malformed)?;
    Ok(Rebuilt { simplified: with_removals(simplified)?, degenerate_triangles })
}

fn malformed(what: impl Display) -> FormatError {
    FormatError::new(Fault::Malformed, "", what.to_string())
}

/// The sequence backwards, as if no step removed a triangle: record *k* of *n* vertices is the
/// split of vertex *n* − 1 − *k* of the stream.
fn sequence_parts(decoder: &MeshDecoder, facts: SequenceFacts, triangles: u32) -> SequenceParts {
    let last = decoder.vertex_count().saturating_sub(1);
    let targets = decoder.targets().iter().skip(1).rev().map(|&target| last - target).collect();
    // A step of the stream begins after a vertex whose step does not continue.
    let continues = decoder.continues();
    let begins = (1..=last).rev().filter(|&new| !continues[new as usize - 1]);
    let step_ends: Vec<u32> = begins.map(|new| last - new + 1).collect();
    SequenceParts {
        targets,
        step_errors: vec![0.0; step_ends.len()],
        step_rms: Vec::new(),
        step_triangles: vec![triangles; step_ends.len()],
        step_ends,
        triangles,
        last_legal_lod: Lod(facts.last_legal_lod),
        topology_changes: facts.topology_changes,
        first_topology_change: facts.first_topology_change.map(Lod),
    }
}

/// Counts the triangles after each step, and puts triangles that are removed first last. They come
/// so unless positions were quantised.
fn with_removals(simplified: Simplified) -> Result<Simplified, FormatError> {
    let removals = removal_lods(&simplified, &PositionIds::new(simplified.mesh().positions()));
    let (mesh, sequence) = simplified.into_parts();
    let (mut mesh, mut sequence) = (mesh.into_parts(), sequence.into_parts());
    let mut sorted = removals.clone();
    sorted.sort_unstable();
    let live =
        |&end: &u32| (sorted.len() - sorted.partition_point(|&removal| removal <= end)) as u32;
    sequence.step_triangles = sequence.step_ends.iter().map(live).collect();
    for submesh in &mesh.submeshes {
        let range = submesh.triangles();
        let mut order: Vec<usize> = range.clone().collect();
        order.sort_by_key(|&t| std::cmp::Reverse(removals[t]));
        let triangles: Vec<[u32; 3]> = order.into_iter().map(|t| mesh.triangles[t]).collect();
        mesh.triangles[range].copy_from_slice(&triangles);
    }
    let mesh = Mesh::try_from(mesh).map_err(malformed)?;
    let sequence = CollapseSequence::try_from(sequence).map_err(malformed)?;
    Simplified::new(mesh, sequence).map_err(malformed)
}

/// Returns strips with their vertices in collapse order; none if the stream has none.
pub(super) fn strips(decoder: &MeshDecoder) -> Option<StripSet> {
    let coded = decoder.strips()?;
    let last = decoder.vertex_count().saturating_sub(1);
    let (mut indices, mut ends) = (Vec::new(), Vec::new());
    for strip in coded.iter() {
        indices.extend(strip.iter().map(|&v| last - v));
        ends.push(indices.len() as u32);
    }
    let submesh_ends = (0..coded.submesh_count()).map(|s| coded.submesh(s).end as u32).collect();
    StripSet::from_parts(indices, ends, submesh_ends).ok()
}
