//! Chooses the LODs of all vertices of a mesh by a criterion, in parallel (`select` has the rule of
//! one vertex).

use super::select::{self, ByError, Parameters};
use super::{Cones, Criterion, Family, LodRange, Point, State, ViewQuery, cones};
use lodc_mesh::{Lod, PositionIds, Shortcuts, Simplified, is_degenerate};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Times, at most, that LODs are refined where triangles are turned over: what is refined may turn
/// others. Chosen by hand.
const MAX_UNFOLDING: u32 = 32;

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
        let state = |(v, &lod): (usize, &u32)| {
            select::state(self.entry(v as u32, lod), lod, &self.links, morph)
        };
        lods.par_iter().enumerate().map(state).collect()
    }

    /// Returns the vertex that is shown for one at a LOD.
    fn entry(&self, vertex: u32, lod: u32) -> u32 {
        let (links, targets) = (&self.links, self.simplified.collapses().targets());
        select::entry(vertex, lod, links, |from| {
            let shortcuts = self.shortcuts.get_or_init(|| Shortcuts::new(targets));
            shortcuts.first(targets, from, |v| links[v as usize][1] > lod)
        })
    }

    /// Refines LODs where a triangle between finer and coarser parts would be turned over: where it
    /// faces away from the input's, or from what it is at the finest LOD of its corners, all three
    /// take that LOD.
    pub fn unfold(&self, lods: &mut [u32], positions: &PositionIds) {
        let mesh = self.simplified.mesh();
        let id = |v: u32| positions.of_vertex[v as usize];
        let faces_away = |a: [u32; 3], b: [u32; 3]| {
            let normals = [a, b].map(|corners| cones::normal(mesh.positions(), corners));
            let [Some(a), Some(b)] = normals else { return false };
            a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < 0.0
        };
        for _ in 0..MAX_UNFOLDING {
            let chosen = &*lods;
            let turned = |&corners: &[u32; 3]| {
                let own = corners.map(|v| chosen[v as usize]);
                let finest = own.into_iter().min().unwrap_or(0);
                if own == [finest; 3] {
                    return None;
                }
                let shown = std::array::from_fn(|i| self.entry(corners[i], own[i]));
                let level = corners.map(|v| self.entry(v, finest));
                let is_turned = faces_away(shown, corners)
                    || !is_degenerate(level.map(id)) && faces_away(shown, level);
                (is_turned && !is_degenerate(shown.map(id))).then_some((corners, finest))
            };
            let turned: Vec<_> = mesh.triangles().par_iter().filter_map(turned).collect();
            if turned.is_empty() {
                break;
            }
            let mut finest_at = vec![u32::MAX; positions.len()];
            for (corners, finest) in turned {
                for v in corners {
                    let at = &mut finest_at[id(v) as usize];
                    *at = finest.min(*at);
                }
            }
            for (lod, &position) in lods.iter_mut().zip(&positions.of_vertex) {
                *lod = finest_at[position as usize].min(*lod);
            }
        }
    }
}
