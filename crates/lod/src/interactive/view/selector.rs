//! Chooses the LODs of all vertices of a mesh by a criterion, in parallel (`select` has the rule of
//! one vertex).

use super::select::{self, ByError, Parameters};
use super::{Cones, Criterion, Family, LodRange, Point, State, ViewQuery};
use lodc_mesh::{Lod, Shortcuts, Simplified};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Selects a LOD for every vertex, the same for all vertices of a wedge group.
#[derive(Clone, Debug)]
pub struct Selector<'a> {
    simplified: &'a Simplified,
    /// The diagonal of the bounding box of the surface in its shape.
    pub(super) diagonal: f64,
    pub(super) points: Vec<Point>,
    pub(super) links: Vec<[u32; 2]>,
    pub(super) by_error: ByError,
    /// Made when a chain of collapses is long, so that no vertex takes long.
    shortcuts: OnceLock<Shortcuts>,
}

impl<'a> Selector<'a> {
    /// Finds groups and cones.
    #[must_use]
    pub fn new(simplified: &'a Simplified) -> Self {
        Self::in_shape(simplified, simplified.mesh().positions())
    }

    /// Finds groups, and cones for a surface whose vertices are at the positions of `shape`: where
    /// a scene shows it, or as joints and morph targets bend it. Criteria are in its units; all
    /// vertices of a group are where the first one is.
    #[must_use]
    pub fn in_shape(simplified: &'a Simplified, shape: &[[f32; 3]]) -> Self {
        let collapses = simplified.collapses();
        let cones = Cones::new(simplified.mesh(), collapses, shape);
        let bound = |pick: fn(f32, f32) -> f32, from: f32| -> [f32; 3] {
            shape.iter().fold([from; 3], |b, p| std::array::from_fn(|i| pick(b[i], p[i])))
        };
        let (low, high) = (bound(f32::min, f32::MAX), bound(f32::max, f32::MIN));
        let square = |i: usize| (f64::from(high[i]) - f64::from(low[i])).powi(2);
        Self {
            simplified,
            diagonal: if shape.is_empty() { 0.0 } else { (0..3).map(square).sum::<f64>().sqrt() },
            points: select::points(&cones, shape),
            links: select::links(collapses),
            by_error: ByError::new(collapses),
            shortcuts: OnceLock::new(),
        }
    }

    /// Returns the numbers that a kernel is given for a view.
    pub(super) fn parameters(&self, view: &ViewQuery) -> Parameters {
        Parameters::new(view, self.diagonal, self.last())
    }

    /// Returns the last LOD.
    pub(super) fn last(&self) -> Lod {
        self.simplified.collapses().last()
    }

    /// Returns the LOD that a criterion wants at each vertex.
    #[must_use]
    pub fn lods(&self, criterion: &Criterion) -> Vec<u32> {
        let parameters = self.parameters(&ViewQuery { criterion: *criterion, morph: false });
        let wanted = |point| select::wanted_lod(&parameters, point, &self.by_error);
        self.points.par_iter().map(wanted).collect()
    }

    /// Returns the LOD that a setting of a family wants at each vertex, none coarser than the last
    /// of `lods`.
    #[must_use]
    pub fn lods_at(&self, family: &Family, setting: u32, lods: &LodRange) -> Vec<u32> {
        let mut wanted = self.lods(&family.criterion(setting, lods));
        wanted.iter_mut().for_each(|lod| *lod = (*lod).min(lods.last.0));
        wanted
    }

    /// Returns the state of each vertex at its LOD.
    #[must_use]
    pub fn states(&self, lods: &[u32], morph: bool) -> Vec<State> {
        let (links, targets) = (&self.links, self.simplified.collapses().targets());
        let state = |(v, &lod): (usize, &u32)| {
            let entry = select::entry(v as u32, lod, links, |from| {
                let shortcuts = self.shortcuts.get_or_init(|| Shortcuts::new(targets));
                shortcuts.first(targets, from, |v| links[v as usize][1] > lod)
            });
            select::state(entry, lod, links, morph)
        };
        lods.par_iter().enumerate().map(state).collect()
    }
}
