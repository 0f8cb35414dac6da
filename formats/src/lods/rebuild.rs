//! Turns a completely received object back into a mesh with its collapse sequence, as a `.lodc`
//! stores it.

use super::document::SequenceFacts;
use crate::{Fault, FormatError};
use lodc_mesh::{CollapseSequence, Lod, Mesh, SequenceParts, Simplified};
use lodc_progressive::{
    BlockTarget, Contexts, MeshDecoder, MeshEncoder, StepBlock, StepOrder, VertexLayout,
    in_batches, with_removals,
};
use std::borrow::Cow;
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
    let simplified = with_removals(simplified).ok_or_else(|| malformed("has no levels"))?;
    Ok(Rebuilt { simplified, degenerate_triangles })
}

/// Returns a mesh with its levels as a lossless stream gives it: with its steps in batches where
/// they can be, and triangles in the order in which they come. Errors are 0: they are to be
/// measured. Its streams give back the same again.
///
/// # Errors
/// Never for a sound mesh: what a stream decodes is checked.
pub fn as_streamed(simplified: &Simplified, order: StepOrder) -> Result<Simplified, FormatError> {
    let ordered = in_batches(simplified, order).map_or(Cow::Borrowed(simplified), Cow::Owned);
    let mut encoder = MeshEncoder::new(&ordered, VertexLayout::choose(&ordered), order);
    let mut decoder = MeshDecoder::new(encoder.header().clone());
    let (mut encoding, mut decoding) = (Box::new(Contexts::new()), Box::new(Contexts::new()));
    let mut bytes_so_far = 0;
    while !encoder.is_complete() {
        let target =
            BlockTarget { bytes: 1 << 16, bytes_before: bytes_so_far, until_triangle: false };
        let block = encoder.encode(&mut encoding, target);
        bytes_so_far += block.splits.len();
        let steps = StepBlock { steps: block.steps, splits: &block.splits, bytes: bytes_so_far };
        decoder.decode(&mut decoding, steps).map_err(|e| malformed(e.0))?;
    }
    let facts = SequenceFacts::of(simplified.collapses());
    let rebuilt = rebuild(&decoder, facts)?.simplified;
    Ok(rebuilt.with_locked_positions(simplified.locked_positions()))
}

fn malformed(problem: impl Display) -> FormatError {
    FormatError::new(Fault::Malformed, "", format!("{problem}"))
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
