//! The stage that measures how far every level is from the input.

use super::Watch;
use super::watch::run_stage;
use crate::{LodObject, stated_shapes};
use lodc_errors::{LevelError, StepErrors, Tick, at_levels};
use lodc_formats::{Document, FormatError, Limits, ObjectInfo, scene_motion};
use lodc_mesh::{Lod, Mesh, Simplified};
use lodc_scene::{Motion, ObjectShapes, Shape};
use lodc_select::decimal;
use rayon::prelude::*;
use std::sync::Arc;

/// How many poses the errors of an object hold in at most besides the one at rest, by default.
/// Chosen by hand: each pose measures every level once more.
pub const DEFAULT_POSES: usize = 8;

/// Replaces the simplifier's estimates of errors by measured distances, several objects at once.
/// Distances are the largest over the shapes that the document's default scene gives an object in
/// its placements, and up to `poses` others, of its animations and morph targets; the object's
/// description names these.
///
/// # Errors
/// If the stored document is damaged.
pub(crate) fn measure_all(
    mut objects: Vec<LodObject>,
    document: &Document,
    limits: &Limits,
    poses: usize,
    watch: &dyn Watch,
) -> Result<Vec<LodObject>, FormatError> {
    let triangles = |s: &Simplified| s.mesh().triangles().len() as u64;
    let all: u64 = objects.iter().map(|o| triangles(&o.simplified)).sum();
    let units = (objects.len() > 1).then_some(all);
    let motion = choose_poses(&mut objects, document, limits, poses)?;
    let one = |(number, object): (usize, LodObject)| {
        let LodObject { mut info, simplified, models } = object;
        let shapes = motion.shapes(simplified.mesh(), number, &info.poses);
        let (distances, poses) = step_errors(&simplified, &shapes, all as usize, &|| watch.add(0));
        info.poses.truncate(poses);
        let measured = Arc::unwrap_or_clone(simplified)
            .with_distances(distances.error, distances.rms)
            .expect("the pass has a distance for each step, none below the one before");
        watch.add(triangles(&measured));
        let line = distances.ends_in_ladder.then(|| {
            format!(
                "{}: errors of coarse levels are measured one by one, and those between are stated \
                 as the next coarser: a mesh like this takes too much work otherwise",
                info.name
            )
        });
        (LodObject { info, simplified: Arc::new(measured), models }, line)
    };
    let measured: Vec<_> = run_stage(watch, "errors", units, || {
        objects.into_par_iter().enumerate().map(one).collect()
    });
    let (objects, lines): (Vec<LodObject>, Vec<Option<String>>) = measured.into_iter().unzip();
    lines.into_iter().flatten().for_each(|line| watch.note(line));
    Ok(objects)
}

/// Shapes given to [`lodc_errors::raise`] at a time where all are to be measured: it measures two
/// before it may stop.
const SHAPES_AT_ONCE: usize = 2;

/// Measures every step of a sequence: the largest distances over all shapes of placements, and over
/// those of pose keys until two of them raise no error noticeably. `scene_triangles` are those of
/// all objects of the scene. Returns how many of the pose keys were measured.
#[must_use]
pub fn step_errors(
    simplified: &Simplified,
    shapes: &ObjectShapes,
    scene_triangles: usize,
    tick: &Tick<'_>,
) -> (StepErrors, usize) {
    let mesh = simplified.mesh();
    let posed = |shape: &'_ Shape| shape.of(mesh).into_owned();
    let (first, others) = shapes.of_placements().split_first().expect("a placement at least");
    let mut errors = lodc_errors::measure(simplified, &first.of(mesh), scene_triangles, tick);
    for some in others.chunks(SHAPES_AT_ONCE) {
        lodc_errors::raise(&mut errors, simplified, some.iter().map(posed), scene_triangles, tick);
    }
    let pose_keys = shapes.of_pose_keys().iter().map(posed);
    let measured = lodc_errors::raise(&mut errors, simplified, pose_keys, scene_triangles, tick);
    // All placements of the last pose key.
    let (pose_keys, all) = shapes.pose_keys_of(measured);
    for some in shapes.of_pose_keys()[measured..all].chunks(SHAPES_AT_ONCE) {
        lodc_errors::raise(&mut errors, simplified, some.iter().map(posed), scene_triangles, tick);
    }
    (errors, pose_keys)
}

/// Puts into the descriptions of objects the poses that their levels are to be measured over: up to
/// `poses` of those in which they have other shapes than at rest. Returns the document's motion.
///
/// # Errors
/// If the stored document is damaged.
pub(crate) fn choose_poses(
    objects: &mut [LodObject],
    document: &Document,
    limits: &Limits,
    poses: usize,
) -> Result<Motion, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let motion = scene_motion(document, &infos, limits)?;
    let meshes: Vec<&Mesh> = objects.iter().map(|o| o.simplified.mesh()).collect();
    let chosen = motion.choose(&meshes, poses);
    for (object, poses) in objects.iter_mut().zip(chosen) {
        object.info.poses = poses;
    }
    Ok(motion)
}

/// Distances of one level of one object from the input, in mesh units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelDistance {
    /// Upper bound of the Hausdorff distance.
    pub error: f64,
    /// Root mean square distance; none if it was not measured.
    pub rms: Option<f64>,
}

impl LevelDistance {
    /// The distances that an object's sequence states of a level.
    #[must_use]
    pub fn stated(object: &LodObject, lod: Lod) -> Self {
        let collapses = object.simplified.collapses();
        Self { error: decimal(collapses.error_at(lod)), rms: collapses.rms_at(lod).map(decimal) }
    }
}

/// Measures only some levels, where the whole sequence would take too long. `levels` are
/// fine to coarse, each with a LOD for every object. Returns the distances of every level and
/// object, the largest over the object's placements and the poses of its description, none below
/// that of a finer level.
///
/// # Errors
/// If the stored document is damaged.
pub(crate) fn measure_levels(
    objects: &[LodObject],
    levels: &[&[Lod]],
    document: &Document,
    limits: &Limits,
    tick: &Tick<'_>,
) -> Result<Vec<Vec<LevelDistance>>, FormatError> {
    let shapes = stated_shapes(objects, document, limits)?;
    let of_object = |(number, object): (usize, &LodObject)| {
        let lods: Vec<Lod> = levels.iter().map(|lods| lods[number]).collect();
        let mesh = object.simplified.mesh();
        let shapes = shapes[number].all().iter().map(|shape| shape.of(mesh));
        let not_below = |before: &mut LevelError, level: LevelError| {
            before.error = before.error.max(level.error);
            before.rms = before.rms.max(level.rms);
            Some(LevelDistance { error: decimal(before.error), rms: Some(decimal(before.rms)) })
        };
        let measured = at_levels(&object.simplified, shapes, &lods, tick);
        let none = LevelError { error: 0.0, rms: 0.0 };
        measured.into_iter().scan(none, not_below).collect()
    };
    let by_object: Vec<Vec<LevelDistance>> =
        objects.par_iter().enumerate().map(of_object).collect();
    let of_level = |level: usize| by_object.iter().map(|levels| levels[level]).collect();
    Ok((0..levels.len()).map(of_level).collect())
}
