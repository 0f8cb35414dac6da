//! The stage that simplifies. Where objects are to look good, pictures decide how.

use super::judge::{Judge, Turns, share_before};
use super::watch::staged;
use super::{SceneContext, SimplifiedObjects, Watch};
use crate::Error;
use lodc_formats::SceneObject;
use lodc_mesh::{Mesh, PositionIds, Simplified};
use lodc_simplify::{
    Begun, Guidance, MetricKind, Moves, Options, SurfaceColours, simplify_with_moves,
};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Scenes of fewer faces (of those that lie on each other one counts) are small: there is time for
/// more samples. They help most models.
const SMALL: u64 = 16_000;
const SAMPLES_OF_SMALL: u32 = 64_000;
/// Simplifies every object by its options. Where that is by `hybrid`, the quadric decides on the
/// way to those levels at which the scene looks worse otherwise: pictures of both decide.
///
/// # Errors
/// If the stored document is damaged.
pub fn simplify_all(
    objects: Vec<SceneObject>,
    options: &[Options],
    known: SceneContext<'_>,
    watch: &dyn Watch,
) -> Result<SimplifiedObjects, Error> {
    staged(watch, "simplify", None, || {
        let scene = Scene { objects: &objects, known, watch };
        if let Some(seen) = scene.best(options)? {
            return Ok(seen);
        }
        scene.begin();
        // Every object goes as soon as it is simplified.
        let objects = objects.into_par_iter().enumerate();
        let one = |(number, object): (usize, SceneObject)| {
            let work = Work { number, options: &options[number], known, watch };
            let (simplified, _) = work.simplified(&object.mesh, None);
            (object.info, simplified)
        };
        Ok(objects.map(one).collect())
    })
}

/// The objects of a scene, to be simplified.
#[derive(Clone, Copy)]
struct Scene<'a> {
    objects: &'a [SceneObject],
    known: SceneContext<'a>,
    watch: &'a dyn Watch,
}

/// A simplification of all objects, with the collapses for another one to begin with.
struct Run {
    objects: SimplifiedObjects,
    moves: Vec<Moves>,
}

/// The way in which `hybrid` and the quadric take turns.
struct Plan<'a> {
    stretches: &'a [[f32; 2]],
    /// The run that it begins as, down to a share of the triangles.
    begun: Option<(&'a Run, f32)>,
}

impl Scene<'_> {
    /// The run that looks best; none if no object is simplified by `hybrid`, or nothing is shown.
    fn best(self, options: &[Options]) -> Result<Option<SimplifiedObjects>, Error> {
        let hybrid = options.iter().any(is_hybrid);
        let judge = if hybrid { Judge::new(self.objects, self.known)? } else { None };
        let Some(judge) = judge else { return Ok(None) };
        let by_quadric = instead(options, |o| Options { metric: MetricKind::Quadric, ..o });
        let quadric = self.run(&by_quadric, None, None);
        let plain = judge.errors(&quadric.objects)?;
        let options = with_samples(options, self.objects, judge.areas());
        let mut turns = Turns::ALL;
        let plan = Plan { stretches: &turns.stretches(), begun: None };
        let mut run = self.run(&options, Some(&plan), Some(&quadric));
        let mut first = 0;
        while let Some(worse) = judge.worse(&run.objects, first, &plain)? {
            let Some(from) = turns.give_way(worse).filter(|_| !turns.are_none()) else {
                return Ok(Some(quadric.objects));
            };
            let begun = Some((&run, share_before(from)));
            let plan = Plan { stretches: &turns.stretches(), begun };
            run = self.run(&options, Some(&plan), Some(&quadric));
            // Of several objects some go further than others: all levels may have changed.
            first = if self.objects.len() == 1 { from } else { 0 };
        }
        Ok(Some(run.objects))
    }

    /// Says how much there is to do.
    fn begin(self) {
        let triangles = |object: &SceneObject| object.mesh.triangles().len() as u64;
        self.watch.begin("simplify", Some(self.objects.iter().map(triangles).sum()));
    }

    /// Simplifies every object by its options, several at once; those that the quadric simplifies
    /// are taken from a run in which it did.
    fn run(self, options: &[Options], plan: Option<&Plan<'_>>, quadric: Option<&Run>) -> Run {
        self.begin();
        let one = |(number, object): (usize, &SceneObject)| {
            if let Some(run) = quadric.filter(|_| !is_hybrid(&options[number])) {
                self.watch.add(object.mesh.triangles().len() as u64);
                return (run.objects[number].clone(), Moves::default());
            }
            let Self { known, watch, .. } = self;
            let work = Work { number, options: &options[number], known, watch };
            let (simplified, moves) = work.simplified(&object.mesh, plan);
            ((object.info.clone(), simplified), moves)
        };
        let (objects, moves) = self.objects.par_iter().enumerate().map(one).unzip();
        Run { objects, moves }
    }
}

/// The simplification of one object.
struct Work<'a> {
    number: usize,
    options: &'a Options,
    known: SceneContext<'a>,
    watch: &'a dyn Watch,
}

impl Work<'_> {
    fn simplified(&self, mesh: &Mesh, plan: Option<&Plan<'_>>) -> (Arc<Simplified>, Moves) {
        let Self { number, options, known, watch } = *self;
        // Objects weigh in by their triangles; each says how many of its groups are gone.
        let weight = mesh.triangles().len() as u64;
        let before = AtomicU64::new(0);
        let report_progress = |gone: u64, groups: u64| {
            let now = weight * gone / groups.max(1);
            let last = before.fetch_max(now, Ordering::Relaxed);
            watch.add(now.saturating_sub(last));
        };
        let textured = known.paints.filter(|p| p.has_textures());
        let colours = textured.map(|p| p.of_object(number));
        let begun = plan.and_then(|plan| plan.begun);
        let guidance = Guidance {
            colours: colours.as_ref().map(|c| c as &dyn SurfaceColours),
            locked: known.importance.locked.get(number).map_or(&[], Vec::as_slice),
            weights: known.importance.weights.get(number).map_or(&[], Vec::as_slice),
            stretches: plan.map(|plan| plan.stretches),
            begun: begun.map(|(run, share)| Begun { moves: &run.moves[number], share }),
        };
        let (simplified, moves) = simplify_with_moves(mesh, options, guidance, &report_progress);
        (Arc::new(simplified), moves)
    }
}

/// The options of the objects with their shares of the scene's samples, by the areas that it shows
/// of them.
fn with_samples(options: &[Options], objects: &[SceneObject], areas: &[f64]) -> Vec<Options> {
    let faces: u64 = objects.par_iter().map(|o| distinct_faces(&o.mesh)).sum();
    let most = options.iter().map(|o| o.hybrid_samples).max().unwrap_or(0);
    let samples = if faces < SMALL { most.max(SAMPLES_OF_SMALL) } else { most };
    let all: f64 = areas.iter().sum();
    let share = |(o, area): (&Options, &f64)| {
        let share = if all > 0.0 { f64::from(samples) * area / all } else { 0.0 };
        Options { hybrid_samples: share as u32, ..*o }
    };
    options.iter().zip(areas).map(share).collect()
}

/// The number of faces of a mesh, of those at the same three positions one.
fn distinct_faces(mesh: &Mesh) -> u64 {
    PositionIds::new(mesh.positions()).distinct(mesh.triangles()).len() as u64
}

fn is_hybrid(options: &Options) -> bool {
    options.metric == MetricKind::Hybrid
}

/// The options of all objects, changed for those that `hybrid` simplifies.
fn instead(options: &[Options], change: impl Fn(Options) -> Options) -> Vec<Options> {
    options.iter().map(|o| if is_hybrid(o) { change(*o) } else { *o }).collect()
}
