//! Distances of every level of detail from the input: for each step of a finished sequence an upper
//! bound of the two-sided Hausdorff distance, and the root mean square distance.
//!
//! Points of the input travel along the sequence, each tied to a face: when a step changes the
//! faces around it, it goes to the nearest one (Klein, Liebich and Straßer 1996; Ciampalini et al.
//! 1997). New faces are measured the other way, to the input. Where either distance comes near the
//! largest one so far, branch and bound decides whether any point is beyond that. The pass knows
//! nothing of the simplifier.
//!
//! Read `pass.rs` first; `docs/design-notes/errors.md` tells the method.
//!
//! ```
//! let mesh = lodc_fixtures::torus();
//! let simplified = lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| ());
//! let distances = lodc_errors::measure(&simplified, simplified.mesh().positions(), 0, &|| ());
//! assert_eq!(distances.error.len(), simplified.collapses().steps());
//! assert!(distances.error.is_sorted(), "coarser is never nearer");
//! ```

mod backward;
mod between;
mod block;
mod check;
mod components;
mod cover;
mod difference;
mod faces;
mod floor;
mod forward;
mod gap;
mod input;
mod ladder;
mod level;
mod origin;
mod pass;
mod rough;
mod samples;
mod settings;
mod step_errors;
mod thinning;
mod work;

pub use between::{Distances, Measurable};
pub use check::check;
pub use level::{LevelError, at_levels};
pub use step_errors::StepErrors;

use floor::Floor;
use input::Input;
use ladder::{Ladder, planned_steps};
use level::Original;
use lodc_mesh::Simplified;
use pass::Pass;
use settings::Settings;

/// An error has risen noticeably in a shape if it is more than this many times what it was, and by
/// more than this share of the diagonal besides: stated errors may be a twentieth too large anyway.
const NOTICEABLE_RATIO: f64 = 1.05;
const NOTICEABLE_SHARE: f64 = 1e-4;

/// Whether errors have risen is judged by levels of at least as many triangles as LOD 0 has,
/// divided by this: below 1 % few levels are used, and errors change by chance.
const COARSEST_DIVISOR: u32 = 100;

/// Meshes of more triangles are measured in one shape at a time: a pass takes about 200 bytes a
/// triangle. Chosen by hand.
const MAX_TRIANGLES_IN_PAIRS: usize = 1 << 20;

/// Of very small meshes each step may change much: their curves are checked, and what would be
/// refused is measured, at most so many times. Chosen by hand.
const MAX_CHECKS: usize = 4;

/// Called now and then while a stage works, by any thread. Where it unwinds, so does the stage, as
/// after a panic.
pub type Tick<'a> = dyn Fn() + Sync + 'a;

/// Measures every step of a sequence. `posed` is the surface that is compared: a position for each
/// vertex of the mesh, in the mesh's units, all finite. `scene_triangles` are those of all meshes
/// of the scene that it is one of: each of many small ones takes a share of the work.
///
/// All threads share the work; the result is the same with any number.
///
/// # Panics
/// If there are not as many positions as vertices.
#[must_use]
pub fn measure(
    simplified: &Simplified,
    posed: &[[f32; 3]],
    scene_triangles: usize,
    tick: &Tick<'_>,
) -> StepErrors {
    let settings = Settings::AT_REST.in_scene(simplified.mesh().triangles().len(), scene_triangles);
    measure_above(&StepErrors::default(), simplified, posed, settings, tick)
}

/// Raises what [`measure`] found to the distances of the same sequence in other shapes, each a
/// position for every vertex, in the same units: the errors are those of the shape in which a step
/// is farthest, the mean distances, too. Distances up to the errors so far are not searched
/// closely.
///
/// Shapes of large effect come first. Two at a time are measured, and none after two that raise no
/// error of a level above 1 % of the triangles by more than a twentieth. Returns how many were.
/// `scene_triangles` as for [`measure`].
///
/// All threads share the work; the result is the same with any number.
///
/// # Panics
/// If there are not as many distances as steps, or not as many positions as vertices in a shape.
pub fn raise<S: AsRef<[[f32; 3]]> + Send>(
    errors: &mut StepErrors,
    simplified: &Simplified,
    mut shapes: impl Iterator<Item = S>,
    scene_triangles: usize,
    tick: &Tick<'_>,
) -> usize {
    assert_eq!(errors.error.len(), simplified.collapses().steps(), "a distance for each step");
    let (collapses, triangles) = (simplified.collapses(), simplified.mesh().triangles().len());
    let coarsest = collapses.lod_for_triangles(triangles as u32 / COARSEST_DIVISOR);
    let counted_steps = collapses.steps_at(coarsest);
    let settings = Settings::IN_POSES.in_scene(triangles, scene_triangles);
    let in_pairs = triangles <= MAX_TRIANGLES_IN_PAIRS;
    let noticeable = NOTICEABLE_SHARE * simplified.mesh().diagonal();
    let mut measured_shapes = 0;
    while let Some(first) = shapes.next() {
        let second = shapes.next();
        let measured = |shape: S| measure_above(errors, simplified, shape.as_ref(), settings, tick);
        let (first, second) = if in_pairs {
            rayon::join(|| measured(first), || second.map(measured))
        } else {
            (measured(first), second.map(measured))
        };
        let before = errors.error.clone();
        for found in std::iter::once(first).chain(second) {
            errors.raise(&found);
            measured_shapes += 1;
        }
        let has_risen = |(&before, &now): (&f32, &f32)| {
            f64::from(now) > NOTICEABLE_RATIO * f64::from(before) + noticeable
        };
        if !before.iter().zip(&errors.error).take(counted_steps).any(has_risen) {
            break;
        }
    }
    measured_shapes
}

/// Measures every step in one shape. What is within the errors `before` is not searched closely,
/// and no step states less than they do.
fn measure_above(
    before: &StepErrors,
    simplified: &Simplified,
    posed: &[[f32; 3]],
    settings: Settings,
    tick: &Tick<'_>,
) -> StepErrors {
    assert_eq!(posed.len(), simplified.mesh().vertex_count(), "a position for each vertex");
    let (input, corner_vertices) = Input::new(simplified, posed);
    let floor = Floor::new(&before.error, input.mesh_scale);
    // Within the pool: else each block would wait for a thread of it to wake.
    rayon::scope(|_| {
        let pass = Pass { input: &input, simplified, floor, settings, tick };
        let sequence = simplified.collapses();
        let mut planned = planned_steps(sequence, settings);
        let proposals = &pass.run(&corner_vertices, &planned);
        let original = Original::new(&input, simplified, &corner_vertices, settings.limits);
        let ladder = Ladder { original, sequence, proposals, floor, settings, tick };
        let mut errors = ladder.complete(&planned);
        if before.error.is_empty() && settings.is_very_small(input.triangles.len()) {
            for _ in 0..MAX_CHECKS {
                let mut refused = refused_steps(simplified, &errors, posed);
                refused.retain(|steps| planned.binary_search(steps).is_err());
                if refused.is_empty() {
                    break;
                }
                planned.extend(refused);
                planned.sort_unstable();
                planned.dedup();
                errors = ladder.complete(&planned);
            }
        }
        errors
    })
}

/// Returns after how many steps levels are not as far as a curve states: those that a check of it
/// would refuse.
fn refused_steps(simplified: &Simplified, errors: &StepErrors, posed: &[[f32; 3]]) -> Vec<usize> {
    let StepErrors { error, rms, .. } = errors.clone();
    let stated = simplified.clone().with_distances(error, rms).expect("errors never fall");
    let steps = |lod| simplified.collapses().steps_at(lod);
    check::refused(&stated, posed).into_iter().map(steps).collect()
}

#[cfg(test)]
mod tests;
