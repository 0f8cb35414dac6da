//! Compares pictures of a scene's levels by two metrics, to tell at which levels `hybrid` looks
//! worse than the quadric.

use super::{SceneContext, SimplifiedObjects};
use crate::level_mesh;
use crate::{Error, LodObject, scene_levels};
use lodc_formats::{ObjectInfo, SceneObject, scene_graph};
use lodc_measure::{ReferencePictures, SceneSurface, ShadingOptions, Surface, Viewing};
use lodc_mesh::{Lod, Mesh};
use lodc_scene::{Appearance, Arrangement, centre, share_in_pictures};
use lodc_select::Target;
use std::sync::Arc;

/// The levels that are compared, as shares of the scene's triangles. Chosen by hand.
const LEVELS: [f64; LEVEL_COUNT] = [0.5, 0.25, 0.1, 0.05, 0.02, 0.01];
pub(super) const LEVEL_COUNT: usize = 6;
/// The image error at each of them: root mean square difference of pixels, 0 to 255.
type ImageErrors = [f64; LEVEL_COUNT];
/// The image errors of a run over those of the quadric's; 1 at levels that are not compared.
type ImageErrorRatios = [f64; LEVEL_COUNT];
/// An image error up to this many times another's counts as equal: fewer pixels than that differ by
/// chance of where edges fall. Chosen by hand.
const TOLERANCE: f64 = 1.01;
/// From this on a level is so much worse that a repeated run does not try it once more. Chosen by
/// hand.
const CLEARLY_WORSE: f64 = 1.05;
/// A run none of whose levels is below this is given up: what it would still gain takes runs, and
/// is less than two nearly equal runs differ by. Chosen by hand.
const GAIN: f64 = 0.97;
/// Triangles of a scene's level below which it resembles nothing and is not compared: on one model
/// a level of six triangles gave all finer levels to the quadric. Chosen by hand.
const MIN_TRIANGLES: f64 = 16.0;
/// The pictures: fewer and smaller than those of `compare`, to save time, and from other sides, so
/// that levels are not chosen by the pictures that measure them. Chosen by hand.
const VIEWING: Viewing = Viewing { views: 12, size: 160 };
/// Scenes whose pictures show more triangles than this are simplified without comparing: a bound on
/// time, chosen by hand.
const MAX_TRIANGLES: usize = 1 << 23;

/// The levels on the way to which `hybrid` chooses collapses; on the way to the others the quadric
/// does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HybridLevels([bool; LEVEL_COUNT]);

impl HybridLevels {
    /// `hybrid` chooses everywhere.
    pub(super) const ALL: Self = Self([true; LEVEL_COUNT]);

    /// What is to be done after a run in which `hybrid` had these levels, of which the first
    /// `compared` have pictures. The way to the first level that looks worse is given to the
    /// quadric, and that to those after it that look clearly worse.
    pub(super) fn after_run(&mut self, ratios: &ImageErrorRatios, compared: usize) -> NextRun {
        let is_worse = |i: &usize| ratios[*i] > TOLERANCE;
        let Some(worse) = (0..compared).find(is_worse) else { return NextRun::None };
        if !ratios[..compared].iter().any(|&ratio| ratio < GAIN) {
            return NextRun::ByQuadric;
        }
        let Some(first) = self.leave_to_quadric(worse) else { return NextRun::ByQuadric };
        for level in (worse + 1..compared).take_while(|&i| ratios[i] > CLEARLY_WORSE) {
            self.0[level] = false;
        }
        if self.0[..compared].contains(&true) { NextRun::From(first) } else { NextRun::ByQuadric }
    }

    /// Gives the way to a level that looks worse to the quadric, or, if the quadric has it already,
    /// the way to the nearest finer level that `hybrid` still has: the quadric cannot repair what
    /// `hybrid` did before. Without one, the nearest coarser level: some of several objects are
    /// there at a finer level of the scene. Returns the level whose way was given; none if the
    /// quadric has all.
    fn leave_to_quadric(&mut self, level: usize) -> Option<usize> {
        let given = (0..=level).rev().chain(level + 1..LEVEL_COUNT).find(|&i| self.0[i])?;
        self.0[given] = false;
        Some(given)
    }

    /// The shares of the triangles between which `hybrid` chooses, the larger of each pair first.
    pub(super) fn ranges(self) -> Vec<[f32; 2]> {
        let mut ranges: Vec<[f32; 2]> = Vec::new();
        for level in (0..LEVELS.len()).filter(|&i| self.0[i]) {
            let (start, end) = (share_at_start(level), share_at_start(level + 1));
            match ranges.last_mut() {
                Some(before) if before[1] == start => before[1] = end,
                _ => ranges.push([start, end]),
            }
        }
        ranges
    }
}

/// The run to be made after one that was judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NextRun {
    /// None: no level looks worse than by the quadric.
    None,
    /// Another one by the changed levels, of which this is the first.
    From(usize),
    /// None: all levels are the quadric's.
    ByQuadric,
}

/// The share of the triangles at which the way to a level begins: the geometric mean of its own and
/// that of the level before.
pub(super) fn share_at_start(level: usize) -> f32 {
    match level {
        0 => 1.0,
        LEVEL_COUNT => 0.0,
        _ => (LEVELS[level - 1] * LEVELS[level]).sqrt() as f32,
    }
}

/// A scene, and reference pictures of it.
pub(super) struct MetricSelection<'a> {
    context: SceneContext<'a>,
    /// The placements that pictures show.
    shown: Arrangement,
    reference: ReferencePictures,
    /// Triangles of the scene, instances counted.
    triangles: usize,
    /// By object.
    areas: Vec<f64>,
}

impl<'a> MetricSelection<'a> {
    /// Takes pictures of a scene; none if it is too large or shows nothing.
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub(super) fn new(
        objects: &[SceneObject],
        context: SceneContext<'a>,
    ) -> Result<Option<Self>, Error> {
        let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
        let graph = scene_graph(context.document, &infos, &context.limits)?;
        let scene = Arrangement::new(&graph, &graph.rest_pose(), objects.len());
        let scene = scene.moved(centre(&scene, |o| &objects[o].mesh).map(|c| -c));
        let count = |object: usize| objects[object].mesh.triangles().len();
        let triangles = scene.triangles(count);
        let shown = scene.thinned(share_in_pictures(triangles));
        if triangles == 0 || shown.triangles(count) > MAX_TRIANGLES {
            return Ok(None);
        }
        let meshes: Vec<&Mesh> = objects.iter().map(|o| &o.mesh).collect();
        let shown_surface = surface(&meshes, &shown, context);
        // Without colours for the metric the pictures show shapes alone.
        let shading = context
            .colours
            .map_or(ShadingOptions::default(), |_| shown_surface.common_shading(&shown_surface));
        let reference = ReferencePictures::new(&shown_surface.surface, VIEWING, shading);
        let mut areas = shown_areas(&shown_surface.surface, &shown, objects);
        for (object, area) in areas.iter_mut().enumerate() {
            *area *= scene.of(object).count() as f64 / shown.of(object).count().max(1) as f64;
        }
        Ok(Some(Self { context, shown, reference, triangles, areas }))
    }

    /// The areas that the scene shows of its objects, instances together; those that pictures leave
    /// out are taken to be as large as the others.
    pub(super) fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// The levels that the quadric makes.
    ///
    /// # Errors
    /// If a level is no mesh: a bug.
    pub(super) fn levels_by_quadric(
        &self,
        objects: &SimplifiedObjects,
    ) -> Result<LevelsByQuadric, Error> {
        let objects = lod_objects(objects);
        let levels = scene_levels(&objects, self.context.document, &self.context.limits)?;
        let is_compared = |share: &f64| self.triangles as f64 * share >= MIN_TRIANGLES;
        let (mut triangles, mut errors) = (Vec::new(), ImageErrors::default());
        for (share, error) in LEVELS.into_iter().take_while(is_compared).zip(&mut errors) {
            let lods = levels.select(Target::Ratio(share))?.lods;
            *error = self.image_error(&objects, &lods)?;
            let of_object = |(o, &lod): (&LodObject, _)| o.simplified.collapses().triangles_at(lod);
            triangles.push(objects.iter().zip(&lods).map(of_object).collect());
        }
        Ok(LevelsByQuadric { triangles, errors })
    }

    /// How much worse the levels of a run look than the quadric's, from index `first` on; those
    /// before keep their `ratios`. A file shares triangles out over objects by distances, which are
    /// measured later: a level counts as it looks with as many for each object as by the quadric,
    /// or, where that is clearly worse, as by what the run's metric takes for distances.
    ///
    /// # Errors
    /// If a level is no mesh: a bug.
    pub(super) fn compare(
        &self,
        objects: &SimplifiedObjects,
        first: usize,
        quadric: &LevelsByQuadric,
        ratios: &mut ImageErrorRatios,
    ) -> Result<(), Error> {
        let objects = lod_objects(objects);
        // One object has as many triangles either way.
        let levels = if objects.len() > 1 {
            Some(scene_levels(&objects, self.context.document, &self.context.limits)?)
        } else {
            None
        };
        for (level, triangles) in quadric.triangles.iter().enumerate().skip(first) {
            let lod = |(o, &count): (&LodObject, &u32)| {
                let collapses = o.simplified.collapses();
                collapses.lod_for_triangles(count).min(collapses.last_visible())
            };
            let lods: Vec<Lod> = objects.iter().zip(triangles).map(lod).collect();
            let mut error = self.image_error(&objects, &lods)?;
            if let Some(levels) = &levels {
                let own = levels.select(Target::Ratio(LEVELS[level]))?.lods;
                if own != lods {
                    error = error.max(self.image_error(&objects, &own)? / CLEARLY_WORSE);
                }
            }
            let by_quadric = quadric.errors[level];
            ratios[level] = if error > 0.0 { error / by_quadric } else { 1.0 };
        }
        Ok(())
    }

    fn image_error(&self, objects: &[LodObject], lods: &[Lod]) -> Result<f64, Error> {
        let meshes = level_mesh::reference_meshes(objects, lods)?;
        let scene_surface = surface(&meshes.iter().collect::<Vec<_>>(), &self.shown, self.context);
        Ok(self.reference.compare(&scene_surface.surface).rmse)
    }
}

/// The levels at [`LEVELS`] by the quadric, without those of fewer than [`MIN_TRIANGLES`].
pub(super) struct LevelsByQuadric {
    /// By level and object.
    triangles: Vec<Vec<u32>>,
    errors: ImageErrors,
}

impl LevelsByQuadric {
    /// The number of levels that are compared.
    pub(super) fn compared(&self) -> usize {
        self.triangles.len()
    }
}

fn lod_objects(objects: &SimplifiedObjects) -> Vec<LodObject> {
    let object = |(info, simplified): &(ObjectInfo, _)| LodObject {
        info: info.clone(),
        simplified: Arc::clone(simplified),
        models: Vec::new(),
    };
    objects.iter().map(object).collect()
}

/// The area of each object on the surface of the placements that pictures show.
fn shown_areas(surface: &Surface, shown: &Arrangement, objects: &[SceneObject]) -> Vec<f64> {
    let mut areas = vec![0.0; objects.len()];
    let mut first = 0;
    for placement in shown.placements() {
        let end = first + objects[placement.object].mesh.triangles().len();
        let area = |t: usize| {
            let [a, b, c] = surface.corners(t);
            0.5 * (b - a).cross(c - a).length()
        };
        areas[placement.object] += (first..end).map(area).sum::<f64>();
        first = end;
    }
    areas
}

/// The surface of a scene, with its images if the metric uses colours.
fn surface(meshes: &[&Mesh], scene: &Arrangement, context: SceneContext<'_>) -> SceneSurface {
    match context.colours {
        None => SceneSurface::new(meshes, scene, &Appearance::default()),
        Some(colours) => {
            SceneSurface::with_images(meshes, scene, colours.appearance(), || colours.images())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{HybridLevels, ImageErrorRatios, LEVELS, NextRun, share_at_start};

    /// The ranges after a run with these image errors over the quadric's.
    fn ranges_after(
        levels: &mut HybridLevels,
        ratios: ImageErrorRatios,
    ) -> (NextRun, Vec<[f32; 2]>) {
        let next = levels.after_run(&ratios, LEVELS.len());
        (next, levels.ranges())
    }

    #[test]
    fn the_quadric_gets_the_level_that_looks_worse_and_then_finer_ones() {
        let mut levels = HybridLevels::ALL;
        assert_eq!(levels.ranges(), [[1.0, 0.0]]);
        let worse = [0.9, 0.9, 0.9, 1.02, 0.9, 1.02];
        let without_3 = vec![[1.0, share_at_start(3)], [share_at_start(4), 0.0]];
        assert_eq!(ranges_after(&mut levels, worse), (NextRun::From(3), without_3));
        // It cannot repair what came before.
        let without_2 = vec![[1.0, share_at_start(2)], [share_at_start(4), 0.0]];
        assert_eq!(ranges_after(&mut levels, worse), (NextRun::From(2), without_2.clone()));
        let as_good = [0.9, 0.9, 1.01, 1.0, 1.0, 1.0];
        assert_eq!(ranges_after(&mut levels, as_good), (NextRun::None, without_2));
    }

    #[test]
    fn the_quadric_gets_all_that_is_clearly_worse_at_once() {
        let mut levels = HybridLevels::ALL;
        let worse = [1.02, 1.2, 1.06, 1.02, 0.9, 0.9];
        let rest = vec![[share_at_start(3), 0.0]];
        assert_eq!(ranges_after(&mut levels, worse), (NextRun::From(0), rest));
    }

    #[test]
    fn several_objects_may_need_a_coarser_level_by_the_quadric() {
        let mut levels = HybridLevels::ALL;
        let worse = [1.2, 0.9, 0.9, 0.9, 0.9, 0.9];
        assert_eq!(levels.after_run(&worse, 6), NextRun::From(0));
        assert_eq!(levels.after_run(&worse, 6), NextRun::From(1));
        assert_eq!(levels.ranges(), [[share_at_start(2), 0.0]]);
    }

    #[test]
    fn the_quadric_has_all_levels_if_none_gains() {
        let after = |ratios, compared| {
            let mut levels = HybridLevels::ALL;
            levels.after_run(&ratios, compared)
        };
        assert_eq!(after([1.6, 1.8, 1.3, 1.1, 0.98, 1.0], 6), NextRun::ByQuadric);
        assert_eq!(after([1.6, 1.8, 1.3, 1.1, 0.9, 1.0], 6), NextRun::From(0));
        // Nothing is known of levels that are not compared.
        assert_eq!(after([1.6, 0.9, 1.02, 1.0, 1.0, 1.0], 3), NextRun::From(0));
        assert_eq!(after([1.6, 1.1, 0.9, 1.0, 1.0, 1.0], 2), NextRun::ByQuadric);
        let mut levels = HybridLevels::ALL;
        assert_eq!(levels.after_run(&[1.02, 0.9, 1.0, 1.0, 1.0, 1.0], 2), NextRun::From(0));
        assert_eq!(levels.after_run(&[1.0, 1.02, 1.0, 1.0, 1.0, 1.0], 2), NextRun::ByQuadric);
        // As good as the quadric is good enough once it is there.
        assert_eq!(after([1.0; 6], 6), NextRun::None);
    }

    #[test]
    fn the_way_to_a_level_begins_beyond_the_one_before() {
        for level in 1..LEVELS.len() {
            let share = f64::from(share_at_start(level));
            assert!(share < LEVELS[level - 1] && share > LEVELS[level], "{share}");
        }
    }
}
