//! Invariants of a collapse sequence that need no levels: what its steps move, and where fakes come
//! from.
//!
//! A *record* turns one vertex into another; a *step* is the records of one half-edge collapse, all
//! of a wedge group. A *fake* is a vertex that no triangle of LOD 0 uses: the simplifier makes one
//! where a wedge has no neighbour at the target's position.

use crate::check::Check;
use crate::difference::Failure;
use lodc_mesh::{Lod, PositionIds, Simplified};

/// Checks that every step moves one position onto one position, and that every fake first appears
/// as the target of a step that also has a target in use before, with the same joints, weights and
/// morph displacements.
pub(super) fn check(simplified: &Simplified, positions: &PositionIds) -> [Check; 2] {
    let sequence = simplified.collapses();
    let mut apart = None;
    let mut fakes = Fakes::new(simplified);
    let mut start = 0;
    for &end in &sequence.parts().step_ends {
        let position = |v: u32| positions.of_vertex[v as usize];
        // A target may disappear within the same step; then its own target counts. Later records
        // are resolved first, as targets come after the vertices that become them.
        let mut final_targets = sequence.targets()[start as usize..end as usize].to_vec();
        for i in (0..final_targets.len()).rev() {
            if final_targets[i] < end {
                final_targets[i] = final_targets[(final_targets[i] - start) as usize];
            }
        }
        let moves = |k: u32| (position(k), position(final_targets[(k - start) as usize]));
        if let Some(record) = (start..end).find(|&k| moves(k) != moves(start)) {
            apart.get_or_insert(Failure::Apart { lod: Lod(end), record });
        }
        fakes.check_step(start, end);
        start = end;
    }
    let lods = sequence.steps() as u64;
    let check = |name, failure| Check { model: "sequence", name, lods, full: 0, failure };
    [check("steps move one position", apart), check("fakes", fakes.failure)]
}

/// Largest number of pairs of a new and an old target of one step that are compared. Chosen by
/// hand, to bound the time that crafted files take: steps of real meshes have a handful of fakes.
/// Beyond it joints, weights and morph displacements of fakes are not compared; models are replayed
/// in any case.
const MAX_PAIRS: usize = 1_000_000;

/// Checks fakes, step by step.
struct Fakes<'a> {
    simplified: &'a Simplified,
    /// Vertices that LOD 0 uses, or that a step before this one leads to.
    in_use: Vec<bool>,
    /// For each submesh the streams that place its vertices (joints, weights, morph displacements),
    /// rising.
    spatial: Vec<Vec<u32>>,
    failure: Option<Failure>,
}

impl<'a> Fakes<'a> {
    fn new(simplified: &'a Simplified) -> Self {
        let mut in_use = vec![false; simplified.mesh().vertex_count()];
        for &v in simplified.mesh().triangles().as_flattened() {
            in_use[v as usize] = true;
        }
        let mesh = simplified.mesh();
        let users = mesh.users_of_streams();
        let mut spatial = vec![Vec::new(); mesh.submeshes().len()];
        for (i, _) in (0..).zip(mesh.attributes()).filter(|(_, stream)| stream.is_spatial()) {
            users.row(i).iter().for_each(|&s| spatial[s as usize].push(i));
        }
        Self { simplified, in_use, spatial, failure: None }
    }

    fn check_step(&mut self, start: u32, end: u32) {
        let targets = &self.simplified.collapses().targets()[start as usize..end as usize];
        // A vertex that disappears without ever having been used.
        let unused = (start..end).find(|&k| !self.in_use[k as usize]);
        let distinct_targets = |in_use: bool| {
            let mut distinct: Vec<u32> =
                targets.iter().copied().filter(|&t| self.in_use[t as usize] == in_use).collect();
            distinct.sort_unstable();
            distinct.dedup();
            distinct
        };
        let (new, old) = (distinct_targets(false), distinct_targets(true));
        let affordable = new.len().saturating_mul(old.len()) <= MAX_PAIRS;
        let misplaced = new
            .into_iter()
            .find(|&f| affordable && !old.iter().any(|&t| self.same_spatial_data(f, t)));
        if let Some(vertex) = unused.or(misplaced) {
            self.failure.get_or_insert(Failure::Fake { vertex });
        }
        for &t in targets {
            self.in_use[t as usize] = true;
        }
    }

    /// Returns whether two targets of a step have the same joints, weights and morph displacements,
    /// where both have such data. That they are at one position is the other check's.
    fn same_spatial_data(&self, a: u32, b: u32) -> bool {
        let mesh = self.simplified.mesh();
        let [streams_a, streams_b] =
            [a, b].map(|v| &self.spatial[mesh.vertex_submesh()[v as usize] as usize]);
        let common = streams_a.iter().filter(|i| streams_b.binary_search(i).is_ok());
        common.map(|&i| &mesh.attributes()[i as usize]).all(|s| s.at(a) == s.at(b))
    }
}
