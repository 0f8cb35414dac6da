//! The stage that simplifies. Where objects are to look good, pictures decide how.

use super::judge::{ALL, Judge, Verdict, shares, verdict};
use super::watch::staged;
use super::{SceneContext, SimplifiedObjects, Watch};
use crate::Error;
use lodc_formats::SceneObject;
use lodc_mesh::{Mesh, PositionIds};
use lodc_simplify::{Guidance, MetricKind, Options, SurfaceColours, simplify_guided};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Scenes of fewer faces (of those that lie on each other one counts) are small: there is time to
/// try more samples first. They help most models and harm some.
const SMALL: u64 = 16_000;
const SAMPLES_OF_SMALL: u64 = 64_000;
/// `hybrid` decides at all levels, then at those where that looked better, then at one fewer: the
/// quadric does not always mend what came before its levels.
const TRIES: usize = 3;

/// Simplifies every object by its options. Where that is by `hybrid`, the quadric decides at those
/// levels at which the scene looks worse otherwise: pictures of both decide.
///
/// # Errors
/// If the stored document is damaged.
pub fn simplify_all(
    objects: Vec<SceneObject>,
    options: &[Options],
    known: SceneContext<'_>,
    watch: &dyn Watch,
) -> Result<SimplifiedObjects, Error> {
    staged(watch, "simplify", None, || best(objects, options, known, watch))
}

fn best(
    objects: Vec<SceneObject>,
    options: &[Options],
    known: SceneContext<'_>,
    watch: &dyn Watch,
) -> Result<SimplifiedObjects, Error> {
    if !options.iter().any(is_hybrid) {
        return Ok(each(objects, options, known, watch));
    }
    let Some(judge) = Judge::new(&objects, known)? else {
        return Ok(each(objects, options, known, watch));
    };
    let by_quadric = instead(options, |o| Options { metric: MetricKind::Quadric, ..o });
    let quadric = each(objects.clone(), &by_quadric, known, watch);
    let plain = judge.errors(&quadric)?;
    for options in with_samples(options, &objects).into_iter().chain([options.to_vec()]) {
        let mut levels = ALL;
        for _ in 0..TRIES {
            let partly = instead(&options, |o| Options { hybrid_between: shares(&levels), ..o });
            let hybrid = each(objects.clone(), &partly, known, watch);
            match verdict(&plain, &judge.errors(&hybrid)?, &levels) {
                Verdict::Everywhere => return Ok(hybrid),
                Verdict::Nowhere => break,
                Verdict::At(fewer) => levels = fewer,
            }
        }
    }
    Ok(quadric)
}

/// The options of the objects of a small scene with more samples, shared out by their triangles;
/// nothing if the scene is not small.
fn with_samples(options: &[Options], objects: &[SceneObject]) -> Option<Vec<Options>> {
    let faces: Vec<u64> = objects.par_iter().map(|o| distinct_faces(&o.mesh)).collect();
    let all: u64 = faces.iter().sum();
    let more = |(o, faces): (&Options, &u64)| {
        let share = SAMPLES_OF_SMALL * faces / all.max(1);
        Options { hybrid_samples: o.hybrid_samples.max(share as u32), ..*o }
    };
    (all < SMALL).then(|| options.iter().zip(&faces).map(more).collect())
}

/// The number of faces of a mesh, of those at the same three positions one.
fn distinct_faces(mesh: &Mesh) -> u64 {
    let positions = PositionIds::new(mesh.positions()).of_vertex;
    let of_face = |t: &[u32; 3]| {
        let mut face = t.map(|v| positions[v as usize]);
        face.sort_unstable();
        face
    };
    let mut faces: Vec<[u32; 3]> = mesh.triangles().iter().map(of_face).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.len() as u64
}

fn is_hybrid(options: &Options) -> bool {
    options.metric == MetricKind::Hybrid
}

/// The options of all objects, changed for those that `hybrid` simplifies.
fn instead(options: &[Options], change: impl Fn(Options) -> Options) -> Vec<Options> {
    options.iter().map(|o| if is_hybrid(o) { change(*o) } else { *o }).collect()
}

/// Simplifies every object by its options, several at once.
fn each(
    objects: Vec<SceneObject>,
    options: &[Options],
    known: SceneContext<'_>,
    watch: &dyn Watch,
) -> SimplifiedObjects {
    let triangles = |object: &SceneObject| object.mesh.triangles().len() as u64;
    watch.begin("simplify", Some(objects.iter().map(triangles).sum()));
    let one = |(number, object): (usize, SceneObject)| {
        // Objects weigh in by their triangles; each says how many of its groups are gone.
        let weight = triangles(&object);
        let before = AtomicU64::new(0);
        let report_progress = |gone: u64, groups: u64| {
            let now = weight * gone / groups.max(1);
            let last = before.fetch_max(now, Ordering::Relaxed);
            watch.add(now.saturating_sub(last));
        };
        let textured = known.paints.filter(|p| p.has_textures());
        let colours = textured.map(|p| p.of_object(number));
        let guidance = Guidance {
            colours: colours.as_ref().map(|c| c as &dyn SurfaceColours),
            locked: known.importance.locked.get(number).map_or(&[], Vec::as_slice),
            weights: known.importance.weights.get(number).map_or(&[], Vec::as_slice),
        };
        let simplified =
            simplify_guided(&object.mesh, &options[number], guidance, &report_progress);
        (object.info, Arc::new(simplified))
    };
    objects.into_par_iter().enumerate().map(one).collect()
}
