//! The removal LOD of each triangle, the first LOD without it. It is derived from the collapse
//! sequence, not stored.

use crate::{PositionIds, Shortcuts, Simplified, is_degenerate};

/// Steps through which the corners of one triangle are followed one by one. Real triangles need
/// about ten. Beyond this number, which takes a sequence made to be slow, bisection finds the LOD.
/// Chosen by hand.
const MAX_STEPS_FOLLOWED: u32 = 200;

/// Returns for each triangle its removal LOD: the first step end at which two of its corners share
/// a position.
///
/// Follows the corners through their collapses, all three together, step by step. Near-linear for
/// any sequence.
#[must_use]
pub fn removal_lods(simplified: &Simplified, positions: &PositionIds) -> Vec<u32> {
    let targets = simplified.collapses().targets();
    let step_ends = &simplified.collapses().parts().step_ends;
    // Record v of the sequence removes vertex v. A step is a run of records; its end is the LOD
    // after it.
    let step_end_of = simplified.collapses().step_ends_by_record();
    let is_removed =
        |corners: [u32; 3]| is_degenerate(corners.map(|v| positions.of_vertex[v as usize]));
    let mut shortcuts = None;
    let removal_lod = |&triangle: &[u32; 3]| {
        let mut corners: [u32; 3] = triangle;
        for _ in 0..MAX_STEPS_FOLLOWED {
            let first = corners[0].min(corners[1]).min(corners[2]);
            // The last vertex has no record; a live triangle has at most one corner there, so
            // `first` is another one.
            let lod = step_end_of[first as usize];
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
