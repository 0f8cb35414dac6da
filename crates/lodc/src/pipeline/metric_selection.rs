//! Compares pictures of a scene's levels by two metrics, to tell at which levels `hybrid` looks
//! worse than the quadric.

use super::{SceneContext, SimplifiedObjects};
use crate::level_mesh;
use crate::{Error, LodObject, scene_levels};
use lodc_formats::{ObjectInfo, SceneObject, scene_graph};
use lodc_measure::{ReferencePictures, SceneSurface, ShadingOptions, Surface, Viewing};
use lodc_mesh::Mesh;
use lodc_scene::{Appearance, Arrangement, centre, share_in_pictures};
use lodc_select::Target;
use std::sync::Arc;

/// The levels that are compared, as shares of the scene's triangles. Chosen by hand.
const LEVELS: [f64; LEVEL_COUNT] = [0.5, 0.25, 0.1, 0.05, 0.02, 0.01];
const LEVEL_COUNT: usize = 6;
/// The image error at each of them: root mean square difference of pixels, 0 to 255.
pub(super) type ImageErrors = [f64; LEVEL_COUNT];
/// An image error up to this many times another's counts as equal: fewer pixels than that differ by
/// chance of where edges fall. Chosen by hand.
const TOLERANCE: f64 = 1.01;
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

    /// Gives the way to a level that looks worse to the quadric, or, if the quadric has it already,
    /// the way to the nearest finer level that `hybrid` still has: the quadric cannot repair what
    /// `hybrid` did before. Returns the level whose way was given; none if the quadric has all.
    pub(super) fn leave_to_quadric(&mut self, level: usize) -> Option<usize> {
        let last = (0..=level).rev().find(|&i| self.0[i])?;
        self.0[last] = false;
        Some(last)
    }

    /// Returns whether the quadric chooses everywhere.
    pub(super) fn is_empty(self) -> bool {
        !self.0.contains(&true)
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

    /// The image errors at [`LEVELS`]; 0 at those of fewer than [`MIN_TRIANGLES`] triangles.
    ///
    /// # Errors
    /// If a level is no mesh: a bug.
    pub(super) fn image_errors(&self, objects: &SimplifiedObjects) -> Result<ImageErrors, Error> {
        let mut errors = ImageErrors::default();
        self.compare_levels(objects, 0, |level, error| {
            errors[level] = error;
            true
        })?;
        Ok(errors)
    }

    /// The first of [`LEVELS`], from index `first` on, that looks worse than by the quadric, whose
    /// errors are given; none if none does.
    ///
    /// # Errors
    /// If a level is no mesh: a bug.
    pub(super) fn first_worse(
        &self,
        objects: &SimplifiedObjects,
        first: usize,
        quadric: &ImageErrors,
    ) -> Result<Option<usize>, Error> {
        let mut worse = None;
        self.compare_levels(objects, first, |level, error| {
            worse = (error > TOLERANCE * quadric[level]).then_some(level);
            worse.is_none()
        })?;
        Ok(worse)
    }

    /// Calls `visit` with the index and the image error of one of [`LEVELS`] after the other, from
    /// `first` on, while it returns true.
    fn compare_levels(
        &self,
        objects: &SimplifiedObjects,
        first: usize,
        mut visit: impl FnMut(usize, f64) -> bool,
    ) -> Result<(), Error> {
        let object = |(info, simplified): &(ObjectInfo, _)| LodObject {
            info: info.clone(),
            simplified: Arc::clone(simplified),
            models: Vec::new(),
        };
        let objects: Vec<LodObject> = objects.iter().map(object).collect();
        let levels = scene_levels(&objects, self.context.document, &self.context.limits)?;
        for (level, share) in LEVELS.into_iter().enumerate().skip(first) {
            if (self.triangles as f64 * share) < MIN_TRIANGLES {
                break;
            }
            let lods = levels.select(Target::Ratio(share), false)?.lods;
            let meshes = level_mesh::reference_meshes(&objects, &lods)?;
            let scene_surface =
                surface(&meshes.iter().collect::<Vec<_>>(), &self.shown, self.context);
            if !visit(level, self.reference.compare(&scene_surface.surface).rmse) {
                break;
            }
        }
        Ok(())
    }
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
    use super::{HybridLevels, LEVELS, share_at_start};

    #[test]
    fn the_quadric_gets_the_level_that_looks_worse_and_then_finer_ones() {
        let mut levels = HybridLevels::ALL;
        assert_eq!(levels.ranges(), [[1.0, 0.0]]);
        assert_eq!(levels.leave_to_quadric(3), Some(3));
        assert_eq!(levels.ranges(), [[1.0, share_at_start(3)], [share_at_start(4), 0.0]]);
        // It cannot repair what came before.
        assert_eq!(levels.leave_to_quadric(3), Some(2));
        assert_eq!(levels.leave_to_quadric(0), Some(0));
        assert_eq!(levels.leave_to_quadric(0), None);
        assert_eq!(levels.ranges().len(), 2);
        while levels.leave_to_quadric(LEVELS.len() - 1).is_some() {}
        assert!(levels.is_empty() && levels.ranges().is_empty());
    }

    #[test]
    fn the_way_to_a_level_begins_beyond_the_one_before() {
        for level in 1..LEVELS.len() {
            let share = f64::from(share_at_start(level));
            assert!(share < LEVELS[level - 1] && share > LEVELS[level], "{share}");
        }
    }
}
