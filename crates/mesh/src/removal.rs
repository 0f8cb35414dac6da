//! The removal LOD of each triangle: derived from the collapse sequence, not stored.

use crate::{PositionIds, Simplified, is_degenerate};

/// Number of steps of one triangle's corners that are followed one by one. Real triangles need
/// about ten; beyond this, which takes a sequence made to be slow, the rest is found by bisection.
const WALK: u32 = 200;

/// Returns for each triangle its removal LOD: the first step end at which two of its corners share
/// a position.
///
/// Follows the corners through their collapses, all three together, step by step. Near-linear for
/// any sequence.
#[must_use]
pub fn removal_lods(simplified: &Simplified, positions: &PositionIds) -> Vec<u32> {
    let targets = simplified.collapses().targets();
    let step_ends = &simplified.collapses().parts().step_ends;
    let end_of = simplified.collapses().step_ends_by_record();
    let dead = |corners: [u32; 3]| is_degenerate(corners.map(|v| positions.of_vertex[v as usize]));
    let mut jumps = None;
    let removal_lod = |&triangle: &[u32; 3]| {
        let mut corners: [u32; 3] = triangle;
        for _ in 0..WALK {
            let first = corners[0].min(corners[1]).min(corners[2]);
            // Two corners at the last vertex are at one position, so a live triangle has an earlier
            // one.
            let lod = end_of[first as usize];
            for v in &mut corners {
                while *v < lod {
                    *v = targets[*v as usize];
                }
            }
            if dead(corners) {
                return lod;
            }
        }
        let jumps = jumps.get_or_insert_with(|| Jumps::new(targets));
        let step = step_ends
            .partition_point(|&end| !dead(triangle.map(|v| jumps.resolve(targets, v, end))));
        step_ends[step]
    };
    simplified.mesh().triangles().iter().map(removal_lod).collect()
}

/// For each vertex one further vertex down its chain of collapses, chosen so that any chain is
/// walked in a logarithmic number of moves (the skew-binary jump pointers of Myers 1983).
struct Jumps(Vec<u32>);

impl Jumps {
    fn new(targets: &[u32]) -> Self {
        let last = targets.len();
        let mut jump = vec![last as u32; last + 1];
        let mut depth = vec![0u32; last + 1];
        for v in (0..last).rev() {
            let next = targets[v] as usize;
            let far = jump[next] as usize;
            let farther = jump[far] as usize;
            depth[v] = depth[next] + 1;
            let even = depth[next] - depth[far] == depth[far] - depth[farther];
            jump[v] = if even { farther } else { next } as u32;
        }
        Self(jump)
    }

    fn resolve(&self, targets: &[u32], mut v: u32, lod: u32) -> u32 {
        while v < lod {
            let far = self.0[v as usize];
            v = if far < lod { far } else { targets[v as usize] };
        }
        v
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_lead_where_single_collapses_lead() {
        for spread in [1, 2, 7, 300] {
            let last = 300u32;
            let targets: Vec<u32> =
                (0..last).map(|v| (v + 1 + v * 7919 % spread).min(last)).collect();
            let jumps = Jumps::new(&targets);
            for v in 0..=last {
                for lod in 0..=last {
                    let mut slow = v;
                    while slow < lod {
                        slow = targets[slow as usize];
                    }
                    assert_eq!(jumps.resolve(&targets, v, lod), slow, "vertex {v}, LOD {lod}");
                }
            }
        }
    }
}
