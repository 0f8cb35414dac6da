//! The stage that measures how far every level is from the input.

use super::watch::staged;
use super::{SimplifiedObjects, Watch};
use lodc_formats::{Document, FormatError, Limits, ObjectInfo, scene_motion};
use lodc_mesh::{Mesh, Simplified};
use rayon::prelude::*;
use std::mem::take;
use std::sync::Arc;

/// Poses that the errors of an object hold in besides the one at rest, unless another number is
/// asked for.
pub const POSES: usize = 8;

/// Puts measured distances in the place of what the simplifier was guided by, several objects at
/// once. Distances are the largest over the shape that the document's default scene gives an object
/// and up to `poses` others, of its animations and morph targets; which ones, its description says.
///
/// # Errors
/// If the stored document is damaged.
pub fn measure_all(
    objects: SimplifiedObjects,
    document: &Document,
    limits: &Limits,
    poses: usize,
    watch: &dyn Watch,
) -> Result<SimplifiedObjects, FormatError> {
    measure_some(objects, document, limits, (poses, false), watch)
}

/// Measures those objects alone that have other shapes than at rest: for levels that are measured
/// when they are made, over the same poses.
///
/// # Errors
/// As [`measure_all`].
pub fn measure_bending(
    objects: SimplifiedObjects,
    document: &Document,
    limits: &Limits,
    poses: usize,
    watch: &dyn Watch,
) -> Result<SimplifiedObjects, FormatError> {
    measure_some(objects, document, limits, (poses, true), watch)
}

fn measure_some(
    mut objects: SimplifiedObjects,
    document: &Document,
    limits: &Limits,
    (poses, only_bending): (usize, bool),
    watch: &dyn Watch,
) -> Result<SimplifiedObjects, FormatError> {
    let triangles = |s: &Simplified| s.mesh().triangles().len() as u64;
    let counted = objects.len() > 1;
    let units = counted.then(|| objects.iter().map(|(_, s)| triangles(s)).sum());
    let infos: Vec<&ObjectInfo> = objects.iter().map(|(info, _)| info).collect();
    let motion = scene_motion(document, &infos, limits)?;
    let meshes: Vec<&Mesh> = objects.iter().map(|(_, simplified)| simplified.mesh()).collect();
    let mut chosen = motion.choose(&meshes, poses);
    objects.iter_mut().zip(&mut chosen).for_each(|((info, _), poses)| info.poses = take(poses));
    let one = |(number, (mut info, simplified)): (usize, (ObjectInfo, Arc<Simplified>))| {
        if only_bending && info.poses.is_empty() {
            return (info, simplified);
        }
        let mesh = simplified.mesh();
        let shapes = motion.shapes(mesh, number, &info.poses);
        let shapes = shapes.iter().map(|shape| shape.of(mesh));
        let (distances, poses) = lodc_errors::measure_over(&simplified, shapes);
        info.poses.truncate(poses);
        let measured = Arc::unwrap_or_clone(simplified)
            .with_distances(distances.error, distances.rms)
            .expect("the pass has a distance for each step, none below the one before");
        watch.add(triangles(&measured));
        (info, Arc::new(measured))
    };
    if only_bending && objects.iter().all(|(info, _)| info.poses.is_empty()) {
        return Ok(objects);
    }
    Ok(staged(watch, "errors", units, || objects.into_par_iter().enumerate().map(one).collect()))
}
