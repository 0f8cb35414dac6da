//! The stage that simplifies. With `hybrid`, pictures decide which levels it makes, and which the
//! quadric.

use super::metric_selection::{
    HybridLevels, LEVEL_COUNT, MetricSelection, NextRun, share_at_start,
};
use super::watch::run_stage;
use super::{SceneContext, SimplifiedObjects, Watch};
use crate::Error;
use lodc_formats::{ObjectInfo, SceneObject, scene_motion};
use lodc_mesh::{Attribute, Mesh, Semantic, Simplified};
use lodc_scene::TargetShape;
use lodc_simplify::{
    Guidance, MetricKind, Options, Prefix, RecordedCollapses, SeenShape, SeenShapes,
    SurfaceColours, Weights, simplify_recorded,
};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Samples for each face of a scene, those that lie on each other counted once, within limits. With
/// the upper limit for all scenes they take a third longer, and most look the same
/// (design-notes/metrics.md).
const SAMPLES_PER_FACE: u64 = 2;
const MAX_SAMPLES: u64 = 64_000;

/// What a caller is told if `hybrid` decides nowhere in the end.
const ALL_BY_QUADRIC: &str =
    "hybrid looks no better than quadric here: all levels are those of quadric";

/// Simplifies every object by its options. Of those with `hybrid`, the quadric chooses the
/// collapses on the way to levels at which the scene would look worse otherwise, by pictures of
/// both.
///
/// # Errors
/// If the stored document is damaged.
pub(crate) fn simplify_all(
    objects: Vec<SceneObject>,
    options: &[Options],
    context: SceneContext<'_>,
    watch: &dyn Watch,
) -> Result<SimplifiedObjects, Error> {
    run_stage(watch, "simplify", None, || {
        let seen = seen_shapes(&objects, options, context)?;
        let scene = SceneWork { objects: &objects, seen: &seen, context, watch };
        if let Some(chosen) = scene.best_by_pictures(options)? {
            return Ok(chosen);
        }
        scene.begin_progress();
        // Taking over the objects frees each mesh as soon as it is simplified.
        let objects = objects.into_par_iter().enumerate();
        let one = |(number, object): (usize, SceneObject)| {
            let (options, seen) = (&options[number], seen[number].as_ref());
            let work = ObjectWork { number, options, seen, context, watch };
            let (simplified, _) = work.simplified(&object.mesh, None);
            (object.info, simplified)
        };
        Ok(objects.map(one).collect())
    })
}

/// The shapes in which each object is seen: none of one that neither joints nor morph targets move.
fn seen_shapes(
    objects: &[SceneObject],
    options: &[Options],
    context: SceneContext<'_>,
) -> Result<Vec<Option<SeenShapes>>, Error> {
    let SceneContext { document, poses, limits, .. } = context;
    let moved =
        |a: &Attribute| a.moves() || a.morph_target.is_some() && a.semantic == Semantic::Normal;
    let moves = |o: &SceneObject| o.mesh.attributes().iter().any(moved);
    if poses == 0 || !objects.iter().any(moves) {
        return Ok(vec![None; objects.len()]);
    }
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let motion = scene_motion(document, &infos, &limits)?;
    let meshes: Vec<&Mesh> = objects.iter().map(|o| &o.mesh).collect();
    let pose_keys = motion.choose(&meshes, poses);
    let seen = |number: usize| {
        let seen = motion.seen(meshes[number], number, &pose_keys[number])?;
        let weighted =
            |weight: f64| move |positions| SeenShape { positions, normals: Vec::new(), weight };
        // Costs are squares of lengths.
        let Weights { skin, morph, .. } = options[number].weights;
        let (skin, morph) = (skin.powi(2), morph.powi(2));
        let joints_move = !seen.poses.is_empty();
        let placements = seen.placements.into_iter().map(weighted(1.0));
        let poses = seen.poses.into_iter().map(weighted(skin));
        let targets = seen.targets.into_iter().map(|shape: TargetShape| {
            let TargetShape { positions, normals } = shape;
            SeenShape { positions, normals, weight: morph }
        });
        let others = placements.chain(poses).chain(targets).collect();
        let (at_rest, normals_at_rest) = (seen.at_rest, seen.normals_at_rest);
        Some(SeenShapes { at_rest, normals_at_rest, others, joints_move })
    };
    Ok((0..objects.len()).into_par_iter().map(seen).collect())
}

/// The objects of a scene, to be simplified.
#[derive(Clone, Copy)]
struct SceneWork<'a> {
    objects: &'a [SceneObject],
    /// The shapes in which each object is seen, if it moves.
    seen: &'a [Option<SeenShapes>],
    context: SceneContext<'a>,
    watch: &'a dyn Watch,
}

/// A simplification of all objects, and its collapses, for another one to repeat from the start.
struct SceneRun {
    objects: SimplifiedObjects,
    recorded: Vec<RecordedCollapses>,
}

/// How a run differs from one in which `hybrid` chooses all collapses.
struct Plan<'a> {
    /// The shares of the triangles between which `hybrid` chooses collapses.
    hybrid_ranges: &'a [[f32; 2]],
    /// An earlier run that it repeats down to a share of the triangles.
    prefix: Option<(&'a SceneRun, f32)>,
}

impl SceneWork<'_> {
    /// The run that looks best in pictures; none if no object is simplified by `hybrid`, or if
    /// there are no pictures of the scene.
    fn best_by_pictures(self, options: &[Options]) -> Result<Option<SimplifiedObjects>, Error> {
        let hybrid = options.iter().any(is_hybrid);
        let selection =
            if hybrid { MetricSelection::new(self.objects, self.context)? } else { None };
        let Some(selection) = selection else { return Ok(None) };
        let by_quadric = |o: &Options| match o.metric {
            MetricKind::Hybrid => Options { metric: MetricKind::Quadric, ..*o },
            _ => *o,
        };
        let by_quadric: Vec<Options> = options.iter().map(by_quadric).collect();
        let quadric = self.run(&by_quadric, None, None);
        let levels_by_quadric = selection.levels_by_quadric(&quadric.objects)?;
        let options = with_samples(options, self.objects, selection.areas());
        let mut hybrid_levels = HybridLevels::ALL;
        let plan = Plan { hybrid_ranges: &hybrid_levels.ranges(), prefix: None };
        let mut run = self.run(&options, Some(&plan), Some(&quadric));
        let (mut first, mut ratios) = (0, [1.0; LEVEL_COUNT]);
        loop {
            selection.compare(&run.objects, first, &levels_by_quadric, &mut ratios)?;
            let from = match hybrid_levels.after_run(&ratios, levels_by_quadric.compared()) {
                NextRun::None => return Ok(Some(run.objects)),
                NextRun::From(level) => level,
                NextRun::ByQuadric => {
                    self.watch.note(ALL_BY_QUADRIC.to_owned());
                    return Ok(Some(quadric.objects));
                }
            };
            let prefix = Some((&run, share_at_start(from)));
            let plan = Plan { hybrid_ranges: &hybrid_levels.ranges(), prefix };
            run = self.run(&options, Some(&plan), Some(&quadric));
            // Several objects reach the share at different levels: all levels may have changed.
            first = if self.objects.len() == 1 { from } else { 0 };
        }
    }

    /// Tells `watch` how many triangles there are.
    fn begin_progress(self) {
        let triangles = |object: &SceneObject| object.mesh.triangles().len() as u64;
        self.watch.begin("simplify", Some(self.objects.iter().map(triangles).sum()));
    }

    /// Simplifies every object by its options, several at once; those that the quadric simplifies
    /// are taken from a run in which it did.
    fn run(
        self,
        options: &[Options],
        plan: Option<&Plan<'_>>,
        quadric: Option<&SceneRun>,
    ) -> SceneRun {
        self.begin_progress();
        let one = |(number, object): (usize, &SceneObject)| {
            if let Some(run) = quadric.filter(|_| !is_hybrid(&options[number])) {
                self.watch.add(object.mesh.triangles().len() as u64);
                return (run.objects[number].clone(), RecordedCollapses::default());
            }
            let Self { context, watch, .. } = self;
            let (options, seen) = (&options[number], self.seen[number].as_ref());
            let work = ObjectWork { number, options, seen, context, watch };
            let (simplified, recorded) = work.simplified(&object.mesh, plan);
            ((object.info.clone(), simplified), recorded)
        };
        let (objects, recorded) = self.objects.par_iter().enumerate().map(one).unzip();
        SceneRun { objects, recorded }
    }
}

/// The simplification of one object.
struct ObjectWork<'a> {
    number: usize,
    options: &'a Options,
    seen: Option<&'a SeenShapes>,
    context: SceneContext<'a>,
    watch: &'a dyn Watch,
}

impl ObjectWork<'_> {
    fn simplified(
        &self,
        mesh: &Mesh,
        plan: Option<&Plan<'_>>,
    ) -> (Arc<Simplified>, RecordedCollapses) {
        let Self { number, options, seen, context, watch } = *self;
        // `watch` counts triangles, the simplifier counts wedge groups.
        let triangles = mesh.triangles().len() as u64;
        let reported = AtomicU64::new(0);
        let report_progress = |gone: u64, groups: u64| {
            let now = triangles * gone / groups.max(1);
            let last = reported.fetch_max(now, Ordering::Relaxed);
            watch.add(now.saturating_sub(last));
        };
        let textured = context.colours.filter(|p| p.has_textures());
        let colours = textured.map(|p| p.of_object(number));
        let prefix = plan.and_then(|plan| plan.prefix);
        let guidance = Guidance {
            colours: colours.as_ref().map(|c| c as &dyn SurfaceColours),
            locked: context.importance.locked.get(number).map_or(&[], Vec::as_slice),
            weights: context.importance.weights.get(number).map_or(&[], Vec::as_slice),
            importance: context
                .importance
                .painted
                .of_vertices
                .get(number)
                .map_or(&[], Vec::as_slice),
            shapes: seen,
            hybrid_ranges: plan.map(|plan| plan.hybrid_ranges),
            prefix: prefix.map(|(run, share)| Prefix { collapses: &run.recorded[number], share }),
        };
        let (simplified, recorded) = simplify_recorded(mesh, options, guidance, &report_progress);
        (Arc::new(simplified), recorded)
    }
}

/// The options of the objects with their shares of the scene's samples, by the areas that it shows
/// of them.
fn with_samples(options: &[Options], objects: &[SceneObject], areas: &[f64]) -> Vec<Options> {
    let faces: u64 = objects.par_iter().map(|o| distinct_faces(&o.mesh)).sum();
    let largest = options.iter().map(|o| o.hybrid_samples).max().unwrap_or(0);
    let samples = (SAMPLES_PER_FACE * faces).min(MAX_SAMPLES).max(u64::from(largest));
    let all: f64 = areas.iter().sum();
    let share = |(o, area): (&Options, &f64)| {
        let share = if all > 0.0 { samples as f64 * area / all } else { 0.0 };
        Options { hybrid_samples: share as u32, ..*o }
    };
    options.iter().zip(areas).map(share).collect()
}

/// The number of faces of a mesh, of those at the same three positions one.
fn distinct_faces(mesh: &Mesh) -> u64 {
    mesh.position_ids().distinct(mesh.triangles()).len() as u64
}

fn is_hybrid(options: &Options) -> bool {
    options.metric == MetricKind::Hybrid
}
