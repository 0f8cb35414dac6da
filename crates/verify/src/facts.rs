//! Facts of a collapse sequence that follow from its records alone.

use crate::check::Check;
use crate::difference::Failure;
use lodc_mesh::{Lod, PositionIds, Simplified};

/// Returns whether every step moves one position onto one position, and every fake is made by a
/// step that belongs there.
pub(super) fn check(simplified: &Simplified, positions: &PositionIds) -> [Check; 2] {
    let sequence = simplified.collapses();
    let mut apart = None;
    let mut fakes = Fakes::new(simplified);
    let mut start = 0;
    for &end in &sequence.parts().step_ends {
        let place = |v: u32| positions.of_vertex[v as usize];
        // A target that disappears within the same step only hands on.
        let mut arrives = sequence.targets()[start as usize..end as usize].to_vec();
        for i in (0..arrives.len()).rev() {
            if arrives[i] < end {
                arrives[i] = arrives[(arrives[i] - start) as usize];
            }
        }
        let moves = |k: u32| (place(k), place(arrives[(k - start) as usize]));
        if let Some(record) = (start..end).find(|&k| moves(k) != moves(start)) {
            apart.get_or_insert(Failure::Apart { lod: Lod(end), record });
        }
        fakes.step(start, end);
        start = end;
    }
    let lods = sequence.steps() as u64;
    let check = |name, failure| Check { model: "sequence", name, lods, full: 0, failure };
    [check("steps move one position", apart), check("fakes", fakes.failure)]
}

struct Fakes<'a> {
    simplified: &'a Simplified,
    /// Vertices that LOD 0 uses, or that a step before this one leads to.
    there: Vec<bool>,
    failure: Option<Failure>,
}

impl<'a> Fakes<'a> {
    fn new(simplified: &'a Simplified) -> Self {
        let mut there = vec![false; simplified.mesh().vertex_count()];
        for &v in simplified.mesh().triangles().as_flattened() {
            there[v as usize] = true;
        }
        Self { simplified, there, failure: None }
    }

    fn step(&mut self, start: u32, end: u32) {
        let targets = &self.simplified.collapses().targets()[start as usize..end as usize];
        let lost = (start..end).find(|&k| !self.there[k as usize]);
        let sorted = |new: bool| {
            let mut some: Vec<u32> =
                targets.iter().copied().filter(|&t| self.there[t as usize] != new).collect();
            some.sort_unstable();
            some.dedup();
            some
        };
        let (new, old) = (sorted(true), sorted(false));
        // A bound on the time that hostile files take: steps of real meshes have a handful of
        // fakes.
        let affordable = new.len().saturating_mul(old.len()) <= 1_000_000;
        let misplaced =
            new.into_iter().find(|&f| affordable && !old.iter().any(|&t| self.same_place(f, t)));
        if let Some(vertex) = lost.or(misplaced) {
            self.failure.get_or_insert(Failure::Fake { vertex });
        }
        for &t in targets {
            self.there[t as usize] = true;
        }
    }

    /// Returns whether two vertices at one position are also moved alike by joints and morph
    /// targets, as far as both can be.
    fn same_place(&self, a: u32, b: u32) -> bool {
        let mesh = self.simplified.mesh();
        let has = |v: u32, stream: u32| {
            mesh.submeshes()[mesh.vertex_submesh()[v as usize] as usize]
                .attributes
                .contains(&stream)
        };
        (0..).zip(mesh.attributes()).all(|(i, stream)| {
            !stream.is_spatial() || !has(a, i) || !has(b, i) || stream.at(a) == stream.at(b)
        })
    }
}
