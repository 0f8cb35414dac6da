//! Discrete levels of detail: five meshes, each with 25 % fewer triangles than the one before
//! (thesis table 3.1).

use lodc_mesh::{CollapseSequence, Lod, OrientedTriangle, Simplified};
use lodc_model::{Array, Changes, Layout, Model, StorageCost, Traffic, report_difference};
use std::sync::Arc;

/// Number of levels.
pub const LEVELS: usize = 5;

/// Five meshes out of one sequence, each complete in itself.
///
/// Unlike a continuous model it shows five LODs only. A cursor that seeks any other LOD shows the
/// finest of the five that has at most the detail asked for; beyond the coarsest one it stays
/// there.
#[derive(Clone, Debug)]
pub struct Discrete {
    simplified: Arc<Simplified>,
    levels: Vec<DiscreteLevel>,
}

#[derive(Clone, Debug)]
struct DiscreteLevel {
    lod: Lod,
    /// In the order in which they are drawn.
    triangles: Vec<OrientedTriangle>,
    /// Number of vertices they use.
    vertices: u64,
}

/// The level of the five that is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cursor(usize);

impl Discrete {
    /// Takes the levels out of a sequence: the finest LODs with at most ¾, ¾², ¾³ and ¾⁴ of the
    /// triangles.
    #[must_use]
    pub fn build(simplified: &Arc<Simplified>) -> Self {
        let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
        let positions = mesh.position_ids();
        let level = |level| {
            let lod = Self::lod(collapses, level);
            let triangles = simplified.triangles_at_with(lod, &positions);
            let mut used = vec![false; mesh.vertex_count()];
            triangles.iter().flat_map(|t| t.corners).for_each(|v| used[v as usize] = true);
            let vertices = used.into_iter().filter(|&u| u).count() as u64;
            DiscreteLevel { lod, triangles, vertices }
        };
        Self { simplified: Arc::clone(simplified), levels: (0..LEVELS).map(level).collect() }
    }

    /// Returns the LOD of a level of a sequence, 0 being the finest; also of those that would
    /// follow the coarsest one.
    #[must_use]
    pub fn lod(collapses: &CollapseSequence, level: usize) -> Lod {
        let level = level.min(16) as u32;
        let wanted = u64::from(collapses.parts().triangles) * 3u64.pow(level) / 4u64.pow(level);
        collapses.lod_for_triangles(wanted as u32)
    }

    /// The LODs that it has, from the finest.
    pub fn lods(&self) -> impl Iterator<Item = Lod> {
        self.levels.iter().map(|l| l.lod)
    }
}

impl Model for Discrete {
    type Cursor = Cursor;

    fn name(&self) -> &'static str {
        "discrete"
    }
    fn simplified(&self) -> &Arc<Simplified> {
        &self.simplified
    }
    fn cursor(&self) -> Cursor {
        Cursor(0)
    }
    fn lod(&self, cursor: &Cursor) -> Lod {
        self.levels[cursor.0].lod
    }
    /// Every level is ready to be drawn, so a move only chooses one.
    fn seek(&self, cursor: &mut Cursor, lod: Lod, changes: &mut impl Changes) -> Traffic {
        let lod = self.simplified.collapses().floor(lod);
        let to = self.levels.partition_point(|l| l.lod < lod).min(LEVELS - 1);
        let [from, now] = [cursor.0, to].map(|level| &self.levels[level]);
        report(from, now, changes);
        cursor.0 = to;
        Traffic { records: from.lod.0.abs_diff(now.lod.0), rewritten: 0 }
    }
    /// The number of the level.
    fn sent(&self, _: Lod, _: Lod, traffic: Traffic) -> u64 {
        if traffic.records == 0 { 0 } else { 4 }
    }
    fn for_each_triangle(&self, cursor: &Cursor, see: impl FnMut(OrientedTriangle)) {
        self.levels[cursor.0].triangles.iter().copied().for_each(see);
    }
    fn drawn(&self, cursor: &Cursor) -> u64 {
        3 * self.levels[cursor.0].triangles.len() as u64
    }
    /// Five meshes, each with vertices and triangles of its own: `Σ 3v + 3f` words, 3.05 times the
    /// triangles alone.
    fn storage_to(&self, _: Lod) -> StorageCost {
        let plain = StorageCost::of_triangles(&self.simplified);
        let geometry = 12 * self.levels.iter().map(|l| l.vertices).sum::<u64>();
        let primitives = 12 * self.levels.iter().map(|l| l.triangles.len() as u64).sum::<u64>();
        StorageCost { positions: geometry, normals: geometry, primitives, ..plain }
    }
    fn arrays(&self, _: Layout) -> Vec<Array> {
        Vec::new()
    }
}

/// Reports what a move from one level to another changes.
fn report<C: Changes>(from: &DiscreteLevel, to: &DiscreteLevel, changes: &mut C) {
    if C::REPORTED {
        let [mut before, mut after] = [from, to].map(|level| level.triangles.clone());
        report_difference(&mut before, &mut after, changes);
    }
}
