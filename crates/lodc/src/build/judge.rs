//! Pictures of a scene's levels, to tell which of two simplifications looks better.

use super::{SceneContext, SimplifiedObjects};
use crate::level_mesh;
use crate::{Error, LodObject, scene_levels};
use lodc_formats::{ObjectInfo, SceneObject, scene_graph};
use lodc_measure::{Portrait, SceneSurface, ShadingOptions, Surface, Viewing};
use lodc_mesh::Mesh;
use lodc_scene::{Appearance, Arrangement};
use lodc_select::Target;
use std::sync::Arc;

/// Levels that are looked at, as shares of the scene's triangles.
const LEVELS: [f64; 6] = [0.5, 0.25, 0.1, 0.05, 0.02, 0.01];
/// The image error at each of them.
pub(super) type Errors = [f64; LEVELS.len()];
/// An image error up to this many times another's is no worse.
const NO_WORSE: f64 = 1.01;
/// Levels of fewer triangles are no picture of anything, and are not compared.
const FEWEST: f64 = 16.0;
/// The pictures: fewer and smaller than those of `compare`, and from other sides.
const VIEWING: Viewing = Viewing { views: 17, size: 256 };
/// Scenes with more triangles than this, instances counted, are not looked at.
const MAX_TRIANGLES: usize = 1 << 23;

/// The levels on the way to which a metric decides; on the way to the others the quadric does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turns([bool; LEVELS.len()]);

impl Turns {
    /// The metric decides everywhere.
    pub(super) const ALL: Self = Self([true; LEVELS.len()]);

    /// Lets the quadric decide on the way to a level that looks worse, or, if it does already, on
    /// the way to the nearest one before it at which it does not: the quadric does not mend what
    /// the metric did before. Returns the level from which on all is different then; none if
    /// nothing can be.
    pub(super) fn give_way(&mut self, level: usize) -> Option<usize> {
        let last = (0..=level).rev().find(|&i| self.0[i])?;
        self.0[last] = false;
        Some(last)
    }

    /// Returns whether the quadric decides everywhere.
    pub(super) fn are_none(self) -> bool {
        !self.0.contains(&true)
    }

    /// The shares of the triangles between which the metric decides, the larger of each pair first.
    pub(super) fn stretches(self) -> Vec<[f32; 2]> {
        let mut stretches: Vec<[f32; 2]> = Vec::new();
        for level in (0..LEVELS.len()).filter(|&i| self.0[i]) {
            let (most, least) = (share_before(level), share_before(level + 1));
            match stretches.last_mut() {
                Some(before) if before[1] == most => before[1] = least,
                _ => stretches.push([most, least]),
            }
        }
        stretches
    }
}

/// The share of the triangles at which the way to a level begins.
pub(super) fn share_before(level: usize) -> f32 {
    match level {
        0 => 1.0,
        LEVELS_END => 0.0,
        _ => (LEVELS[level - 1] * LEVELS[level]).sqrt() as f32,
    }
}

const LEVELS_END: usize = LEVELS.len();

/// A scene, and reference pictures of it.
pub(super) struct Judge<'a> {
    known: SceneContext<'a>,
    scene: Arrangement,
    portrait: Portrait,
    /// Those of the scene, instances counted.
    triangles: usize,
    areas: Vec<f64>,
}

impl<'a> Judge<'a> {
    /// Takes pictures of a scene; none if it is too large or shows nothing.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub(super) fn new(
        objects: &[SceneObject],
        known: SceneContext<'a>,
    ) -> Result<Option<Self>, Error> {
        let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
        let graph = scene_graph(known.document, &infos, &known.limits)?;
        let scene = Arrangement::new(&graph, &graph.rest_pose(), objects.len());
        let count = |object: usize| objects[object].mesh.triangles().len();
        let counts = scene.placements().iter().map(|p| count(p.object));
        let triangles = counts.fold(0, usize::saturating_add);
        if triangles == 0 || triangles > MAX_TRIANGLES {
            return Ok(None);
        }
        let meshes: Vec<&Mesh> = objects.iter().map(|o| &o.mesh).collect();
        let shown = surface(&meshes, &scene, known);
        // Shapes alone where the metric sees no more.
        let looks = known.paints.map_or(ShadingOptions::default(), |_| shown.common_looks(&shown));
        let portrait = Portrait::new(&shown.surface, VIEWING, looks);
        let areas = areas(&shown.surface, &scene, objects);
        Ok(Some(Self { known, scene, portrait, triangles, areas }))
    }

    /// The areas that the scene shows of its objects, instances together.
    pub(super) fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// The image errors at [`LEVELS`]; 0 at those of fewer than [`FEWEST`] triangles.
    ///
    /// # Errors
    /// If a level is no mesh: a bug.
    pub(super) fn errors(&self, objects: &SimplifiedObjects) -> Result<Errors, Error> {
        let mut errors = Errors::default();
        self.look(objects, 0, |level, error| {
            errors[level] = error;
            true
        })?;
        Ok(errors)
    }

    /// The first of [`LEVELS`], not before `first`, that looks worse than by the quadric, whose
    /// errors are given.
    ///
    /// # Errors
    /// If a level is no mesh: a bug.
    pub(super) fn worse(
        &self,
        objects: &SimplifiedObjects,
        first: usize,
        quadric: &Errors,
    ) -> Result<Option<usize>, Error> {
        let mut worse = None;
        self.look(objects, first, |level, error| {
            worse = (error > NO_WORSE * quadric[level]).then_some(level);
            worse.is_none()
        })?;
        Ok(worse)
    }

    /// Calls `see` with the image error of one of [`LEVELS`] after the other, from `first` on,
    /// while it returns true.
    fn look(
        &self,
        objects: &SimplifiedObjects,
        first: usize,
        mut see: impl FnMut(usize, f64) -> bool,
    ) -> Result<(), Error> {
        let object = |(info, simplified): &(ObjectInfo, _)| LodObject {
            info: info.clone(),
            simplified: Arc::clone(simplified),
            models: Vec::new(),
        };
        let objects: Vec<LodObject> = objects.iter().map(object).collect();
        let levels = scene_levels(&objects, self.known.document, &self.known.limits)?;
        for (level, share) in LEVELS.into_iter().enumerate().skip(first) {
            if (self.triangles as f64 * share) < FEWEST {
                break;
            }
            let lods = levels.select(Target::Ratio(share), false)?.lods;
            let meshes = level_mesh::plain(&objects, &lods)?;
            let shown = surface(&meshes.iter().collect::<Vec<_>>(), &self.scene, self.known);
            if !see(level, self.portrait.compare(&shown.surface).rmse) {
                break;
            }
        }
        Ok(())
    }
}

/// The area of each object on the surface of a scene.
fn areas(shown: &Surface, scene: &Arrangement, objects: &[SceneObject]) -> Vec<f64> {
    let mut areas = vec![0.0; objects.len()];
    let mut first = 0;
    for placement in scene.placements() {
        let end = first + objects[placement.object].mesh.triangles().len();
        let area = |t: usize| {
            let [a, b, c] = shown.corners(t);
            0.5 * (b - a).cross(c - a).length()
        };
        areas[placement.object] += (first..end).map(area).sum::<f64>();
        first = end;
    }
    areas
}

/// A scene as it is shown.
fn surface(meshes: &[&Mesh], scene: &Arrangement, known: SceneContext<'_>) -> SceneSurface {
    match known.paints {
        None => SceneSurface::new(meshes, scene, &Appearance::default()),
        Some(paints) => {
            SceneSurface::with_images(meshes, scene, paints.looks(), || paints.images())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LEVELS, Turns, share_before};

    #[test]
    fn the_quadric_decides_where_a_level_looks_worse_and_then_before_it() {
        let mut turns = Turns::ALL;
        assert_eq!(turns.stretches(), [[1.0, 0.0]]);
        assert_eq!(turns.give_way(3), Some(3));
        assert_eq!(turns.stretches(), [[1.0, share_before(3)], [share_before(4), 0.0]]);
        // It does not mend what came before.
        assert_eq!(turns.give_way(3), Some(2));
        assert_eq!(turns.give_way(0), Some(0));
        assert_eq!(turns.give_way(0), None);
        assert_eq!(turns.stretches().len(), 2);
        while turns.give_way(LEVELS.len() - 1).is_some() {}
        assert!(turns.are_none() && turns.stretches().is_empty());
    }

    #[test]
    fn the_way_to_a_level_begins_beyond_the_one_before() {
        for level in 1..LEVELS.len() {
            let share = f64::from(share_before(level));
            assert!(share < LEVELS[level - 1] && share > LEVELS[level], "{share}");
        }
    }
}
