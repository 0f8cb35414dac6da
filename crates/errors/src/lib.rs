//! Distances of every level of detail from the input: for each step of a finished sequence an upper
//! bound of the two-sided Hausdorff distance, and the root mean square distance.
//!
//! Points of the input travel along the sequence, each tied to a face: when a step changes the
//! faces around it, it goes to the nearest one (Klein, Liebich and Straßer 1996; Ciampalini et al.
//! 1997). New faces are asked the other way. Where either is near the largest distance so far,
//! branch and bound looks closer. The pass knows nothing of the simplifier.
//!
//! ```
//! let mesh = lodc_fixtures::torus();
//! let simplified = lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| ());
//! let distances = lodc_errors::measure(&simplified, simplified.mesh().positions());
//! assert_eq!(distances.error.len(), simplified.collapses().steps());
//! assert!(distances.error.is_sorted(), "coarser is never nearer");
//! ```

mod ask;
mod backward;
mod block;
mod direct;
mod faces;
mod follower;
mod forward;
mod gap;
mod input;
mod pass;
mod refine;
mod samples;
mod step_errors;
mod thinning;
mod work;

pub use step_errors::StepErrors;

use lodc_mesh::Simplified;

/// Measures every step of a sequence. `shown` is the surface that is compared: a place for each
/// vertex of the mesh, in the mesh's units, all finite.
///
/// Two threads share the work; the result is the same with one.
///
/// # Panics
/// If there are not as many places as vertices.
#[must_use]
pub fn measure(simplified: &Simplified, shown: &[[f32; 3]]) -> StepErrors {
    assert_eq!(shown.len(), simplified.mesh().vertex_count(), "a place for each vertex");
    let (input, wedges) = input::Input::new(simplified, shown);
    rayon::scope(|_| {
        let mut errors = pass::run(&input, wedges, simplified);
        direct::complete(&mut errors, &input, simplified);
        errors
    })
}

#[cfg(test)]
mod tests;
