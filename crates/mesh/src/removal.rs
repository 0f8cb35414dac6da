//! The removal LOD of each triangle: derived from the collapse sequence, not stored.

use crate::{PositionIds, Shortcuts, Simplified, is_degenerate};

/// Number of steps of one triangle's corners that are followed one by one. Real triangles need
/// about ten; beyond this, which takes a sequence made to be slow, bisection finds the LOD.
const MAX_WALK: u32 = 200;

/// Returns for each triangle its removal LOD: the first step end at which two of its corners share
/// a position.
///
/// Follows the corners through their collapses, all three together, step by step. Near-linear for
/// any sequence.
#[must_use]
pub fn removal_lods(simplified: &Simplified, positions: &PositionIds) -> Vec<u32> {
    let targets = simplified.collapses().targets();
    let step_ends = &simplified.collapses().parts().step_ends;
    // Vertex v moves by record v of the sequence; a step is a run of records, its end the LOD after
    // it.
    let end_of = simplified.collapses().step_ends_by_record();
    let is_removed =
        |corners: [u32; 3]| is_degenerate(corners.map(|v| positions.of_vertex[v as usize]));
    let mut shortcuts = None;
    let removal_lod = |&triangle: &[u32; 3]| {
        let mut corners: [u32; 3] = triangle;
        for _ in 0..MAX_WALK {
            let first = corners[0].min(corners[1]).min(corners[2]);
            // The last vertex has no record; a live triangle has at most one corner there, so
            // `first` is another one.
            let lod = end_of[first as usize];
            for v in &mut corners {
                while *v < lod {
                    *v = targets[*v as usize];
                }
            }
            if is_removed(corners) {
                return lod;
            }
        }
        let shortcuts = shortcuts.get_or_insert_with(|| Shortcuts::new(targets));
        let resolve = |v: u32, end: u32| shortcuts.first(targets, v, |v| v >= end);
        let step = step_ends.partition_point(|&end| !is_removed(triangle.map(|v| resolve(v, end))));
        step_ends[step]
    };
    simplified.mesh().triangles().iter().map(removal_lod).collect()
}
