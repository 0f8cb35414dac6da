//! Distances of every level of detail from the input: for each step of a finished sequence an upper
//! bound of the two-sided Hausdorff distance, and the root mean square distance.
//!
//! Points of the input travel along the sequence, each tied to a face: when a step changes the
//! faces around it, it goes to the nearest one (Klein, Liebich and Straßer 1996; Ciampalini et al.
//! 1997). New faces are looked at the other way. Where either is near the largest distance so far,
//! branch and bound decides whether a point is beyond it. The pass knows nothing of the simplifier.
//!
//! ```
//! let mesh = lodc_fixtures::torus();
//! let simplified = lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| ());
//! let distances = lodc_errors::measure(&simplified, simplified.mesh().positions(), &|| ());
//! assert_eq!(distances.error.len(), simplified.collapses().steps());
//! assert!(distances.error.is_sorted(), "coarser is never nearer");
//! ```

mod backward;
mod block;
mod direct;
mod faces;
mod floor;
mod follower;
mod forward;
mod gap;
mod input;
mod levels;
mod pass;
mod samples;
mod step_errors;
mod thinning;
mod thresholds;
mod work;

pub use levels::{LevelError, at_levels};
pub use step_errors::StepErrors;

use floor::Floor;
use lodc_mesh::Simplified;
use thresholds::Thresholds;

/// An error counts as raised if it is more than this many times itself, and this share of the
/// diagonal besides: a twentieth is what stated errors may be too large by anyway.
const RISE: f64 = 1.05;
const TINY: f64 = 1e-4;

/// Levels of fewer triangles than one in this many do not count for that: below 1 % few are used,
/// and errors change by chance.
const COARSEST: u32 = 100;

/// Meshes of more triangles are measured in one shape at a time: a pass takes about 200 bytes a
/// triangle.
const MANY: usize = 1 << 20;

/// Called now and then while a stage works, by any thread. Where it unwinds, so does the stage, as
/// after a panic.
pub type Tick<'a> = dyn Fn() + Sync + 'a;

/// Measures every step of a sequence. `shown` is the surface that is compared: a place for each
/// vertex of the mesh, in the mesh's units, all finite.
///
/// Two threads share the work; the result is the same with one.
///
/// # Panics
/// If there are not as many places as vertices.
#[must_use]
pub fn measure(simplified: &Simplified, shown: &[[f32; 3]], tick: &Tick<'_>) -> StepErrors {
    measure_above(simplified, shown, (&StepErrors::default(), Thresholds::AT_REST), tick)
}

/// Measures every step of a sequence in several shapes, [`measure`] in the first and [`raise`] in
/// the others. Returns how many others were measured, too.
///
/// # Panics
/// If there is no shape, or not as many places as vertices in one.
pub fn measure_over<S: AsRef<[[f32; 3]]> + Send>(
    simplified: &Simplified,
    mut shapes: impl Iterator<Item = S>,
    tick: &Tick<'_>,
) -> (StepErrors, usize) {
    let mut errors = measure(simplified, shapes.next().expect("a shape").as_ref(), tick);
    let raised = raise(&mut errors, simplified, shapes, tick);
    (errors, raised)
}

/// Raises what [`measure`] found to the distances of the same sequence in other shapes, in the
/// same units: the errors are those of the shape in which a step is farthest, the mean distances,
/// too. What is not above the errors that are there is not looked at closely.
///
/// Shapes of large effect come first. Two at a time are measured, and none after two that raise no
/// error of a level above 1 % of the triangles by more than a twentieth. Returns how many were.
///
/// Two threads share the work; the result is the same with one.
///
/// # Panics
/// If there are not as many distances as steps, or not as many places as vertices in a shape.
pub fn raise<S: AsRef<[[f32; 3]]> + Send>(
    errors: &mut StepErrors,
    simplified: &Simplified,
    mut shapes: impl Iterator<Item = S>,
    tick: &Tick<'_>,
) -> usize {
    assert_eq!(errors.error.len(), simplified.collapses().steps(), "a distance for each step");
    let tiny = TINY * simplified.mesh().diagonal();
    let (collapses, triangles) = (simplified.collapses(), simplified.mesh().triangles().len());
    let coarsest = collapses.lod_for_triangles(triangles as u32 / COARSEST);
    let looked_at = collapses.steps_at(coarsest);
    let thresholds =
        Thresholds { threads: if triangles > MANY { 2 } else { 4 }, ..Thresholds::IN_POSES };
    let mut count = 0;
    while let Some(first) = shapes.next() {
        let second = shapes.next();
        let look = |shape: S| measure_above(simplified, shape.as_ref(), (errors, thresholds), tick);
        let (first, second) = if triangles > MANY {
            (look(first), second.map(look))
        } else {
            rayon::join(|| look(first), || second.map(look))
        };
        let before = errors.error.clone();
        for found in std::iter::once(first).chain(second) {
            errors.raise(&found);
            count += 1;
        }
        let rises =
            |(&before, &now): (&f32, &f32)| f64::from(now) > RISE * f64::from(before) + tiny;
        if !before.iter().zip(&errors.error).take(looked_at).any(rises) {
            break;
        }
    }
    count
}

fn measure_above(
    simplified: &Simplified,
    shown: &[[f32; 3]],
    (before, thresholds): (&StepErrors, Thresholds),
    tick: &Tick<'_>,
) -> StepErrors {
    assert_eq!(shown.len(), simplified.mesh().vertex_count(), "a place for each vertex");
    let (input, wedges) = input::Input::new(simplified, shown);
    let floor = Floor::new(&before.error, input.unit);
    rayon::scope(|_| {
        let mut errors = pass::run(&input, wedges, simplified, (floor, thresholds), tick);
        direct::complete(&mut errors, &input, (simplified, shown), tick);
        errors
    })
}

#[cfg(test)]
mod tests;
