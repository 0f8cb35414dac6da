//! Sets of vertices that have to stay at one position, because a triangle is removed as long as
//! they do: union-find.
//!
//! A triangle with two corners at one position is dead for as long as these two corners stay
//! together, wherever they go. So dead triangles need not be moved: it is enough to know that no
//! set of vertices tied that way ever comes apart. Sets only grow, which makes this union-find.

use lodc_mesh::PositionIds;
use std::ops::Range;

/// Disjoint sets of vertices. All vertices of a set that have not disappeared are at one position.
#[derive(Clone, Debug)]
pub(super) struct Ties {
    parent: Vec<u32>,
    /// For each root the number of vertices of its set that have not disappeared.
    remaining: Vec<u32>,
    /// For each root the position of these.
    position: Vec<u32>,
}

impl Ties {
    /// The sets after the records before `lod`, with nothing tied yet: each vertex with all those
    /// that have become it.
    pub(super) fn new(targets: &[u32], lod: u32, positions: &PositionIds) -> Self {
        let vertices = positions.of_vertex.len() as u32;
        let mut ties = Self {
            parent: (0..vertices).collect(),
            remaining: (0..vertices).map(|v| u32::from(v >= lod)).collect(),
            position: positions.of_vertex.clone(),
        };
        // Later vertices are roots already, so the paths stay short.
        for record in (0..lod).rev() {
            ties.parent[record as usize] = ties.parent[targets[record as usize] as usize];
        }
        ties
    }

    /// The root of a vertex's set.
    pub(super) fn set(&mut self, mut v: u32) -> u32 {
        while self.parent[v as usize] != v {
            let grandparent = self.parent[self.parent[v as usize] as usize];
            self.parent[v as usize] = grandparent;
            v = grandparent;
        }
        v
    }

    /// Joins the sets of two vertices, which have to stay together from now on. Returns whether
    /// they can: whether their sets are at one position.
    pub(super) fn tie(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.set(a), self.set(b));
        if a == b {
            return true;
        }
        let (root, child) = (a.max(b) as usize, a.min(b) as usize);
        let both_remain = self.remaining[root] > 0 && self.remaining[child] > 0;
        let same_position = !both_remain || self.position[root] == self.position[child];
        if self.remaining[root] == 0 {
            self.position[root] = self.position[child];
        }
        self.parent[child] = root as u32;
        self.remaining[root] += self.remaining[child];
        same_position
    }

    /// Applies the records of a step. False if a set comes apart. If the step is known to be one
    /// move of one group, its vertices are tied to each other as well.
    pub(super) fn step(&mut self, targets: &[u32], records: Range<u32>, one_group: bool) -> bool {
        for record in records.clone() {
            let set = self.set(record) as usize;
            self.remaining[set] -= 1;
        }
        let mut same_position = true;
        // The last first: a target that disappears in the same step has then been moved already.
        for record in records.clone().rev() {
            same_position &= self.tie(record, targets[record as usize]);
        }
        if one_group {
            for record in records.clone() {
                same_position &= self.tie(record, records.start);
            }
        }
        same_position
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(positions: &[u32]) -> PositionIds {
        PositionIds::new(&positions.iter().map(|&p| [p as f32, 0.0, 0.0]).collect::<Vec<_>>())
    }

    #[test]
    fn tied_vertices_may_move_together_but_not_apart() {
        // 0 and 1 are at one position, 2 and 3 at another, 4 and 5 at a third.
        let positions = at(&[0, 0, 1, 1, 2, 2]);
        for (targets, same_position) in [([2, 3, 4, 5, 5], true), ([2, 4, 4, 5, 5], false)] {
            let mut ties = Ties::new(&targets, 0, &positions);
            assert!(ties.tie(0, 1));
            assert_eq!(ties.step(&targets, 0..2, false), same_position);
        }
        // One of the two goes, the other stays.
        let targets = [2, 3, 4, 5, 5];
        let mut ties = Ties::new(&targets, 0, &positions);
        assert!(ties.tie(0, 1));
        assert!(!ties.step(&targets, 0..1, false));
        // Nothing is tied: whatever moves may.
        let mut ties = Ties::new(&targets, 0, &positions);
        assert!(ties.step(&targets, 0..1, false) && ties.step(&targets, 1..2, false));
        // What was united by records counts as one.
        assert_eq!(ties.set(0), ties.set(2));
        assert_ne!(ties.set(0), ties.set(3));
    }

    #[test]
    fn sets_made_for_a_later_lod_are_those_that_steps_lead_to() {
        let positions = at(&[0, 1, 2, 3, 4, 5]);
        let targets = [3, 2, 5, 4, 5];
        for lod in 0..=5 {
            let (mut made, mut stepped) =
                (Ties::new(&targets, lod, &positions), Ties::new(&targets, 0, &positions));
            for record in 0..lod {
                assert!(stepped.step(&targets, record..record + 1, false));
            }
            for v in 0..6 {
                for w in 0..6 {
                    assert_eq!(
                        made.set(v) == made.set(w),
                        stepped.set(v) == stepped.set(w),
                        "LOD {lod}"
                    );
                }
            }
        }
    }
}
