//! How far every level of detail is from the input: for each step of a finished sequence an upper
//! bound of the two-sided Hausdorff distance, and the root mean square distance.
//!
//! Points of the input travel along the sequence, each tied to a face: when a step changes the faces
//! around it, it goes to the nearest one (Klein, Liebich and Straßer 1996; Ciampalini et al. 1997).
//! New faces are asked the other way. Where either is near the largest distance so far, branch and
//! bound looks closer. The pass knows nothing of the simplifier.

mod backward;
mod faces;
mod input;
mod pass;
mod refine;
mod samples;
mod tree;
mod triangle;

use lodc_mesh::Simplified;

/// Distances from LOD 0 after each step, in the mesh's units. They never fall; infinite once a mesh
/// that had triangles has none left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepErrors {
    /// An upper bound of the Hausdorff distance between both surfaces, up to what sampling can
    /// know.
    pub error: Vec<f32>,
    /// The root mean square distance over the area, the larger of both ways, as far as it has come.
    pub rms: Vec<f32>,
}

impl StepErrors {
    fn with_capacity(steps: usize) -> Self {
        Self { error: Vec::with_capacity(steps), rms: Vec::with_capacity(steps) }
    }

    fn push(&mut self, error: f64, rms: f64) {
        let after = |list: &[f32], x: f64| {
            let nearest = x as f32;
            let above = if f64::from(nearest) < x { nearest.next_up() } else { nearest };
            list.last().map_or(above, |&before| above.max(before))
        };
        self.error.push(after(&self.error, error));
        self.rms.push(after(&self.rms, rms));
    }
}

/// Measures every step of a sequence. `shown` is the surface that is compared: a place for each
/// vertex of the mesh, in the mesh's units, all finite.
///
/// The result does not depend on threads.
///
/// # Panics
/// If there are not as many places as vertices.
#[must_use]
pub fn measure(simplified: &Simplified, shown: &[[f32; 3]]) -> StepErrors {
    assert_eq!(shown.len(), simplified.mesh().vertex_count(), "a place for each vertex");
    let input = input::Input::new(simplified, shown);
    pass::Pass::new(&input).run(simplified)
}
