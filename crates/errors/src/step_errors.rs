//! The distances that a pass finds.

/// Distances from LOD 0 after each step, in the mesh's units. They never fall; infinite once a mesh
/// that had triangles has none left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepErrors {
    /// An upper bound of the Hausdorff distance between both surfaces, up to what sampling can
    /// know.
    pub error: Vec<f32>,
    /// The largest root mean square distance so far, over the area, the larger of both ways.
    pub rms: Vec<f32>,
}

impl StepErrors {
    pub(crate) fn with_capacity(steps: usize) -> Self {
        Self { error: Vec::with_capacity(steps), rms: Vec::with_capacity(steps) }
    }

    /// Takes over what is larger for the same steps.
    pub(crate) fn raise(&mut self, other: &Self) {
        let each = |own: &mut [f32], other: &[f32]| {
            own.iter_mut().zip(other).for_each(|(own, &other)| *own = own.max(other));
        };
        each(&mut self.error, &other.error);
        each(&mut self.rms, &other.rms);
    }

    /// Adds a step: distances are rounded up and kept from falling.
    pub(crate) fn push(&mut self, error: f64, rms: f64) {
        self.error.push(not_below(&self.error, error));
        self.rms.push(not_below(&self.rms, rms));
    }
}

/// Returns a distance, rounded up.
pub(crate) fn above(distance: f64) -> f32 {
    let nearest = distance as f32;
    let above = if f64::from(nearest) < distance { nearest.next_up() } else { nearest };
    // What is too large for the type is no missing surface.
    if distance.is_finite() { above.min(f32::MAX) } else { above }
}

fn not_below(list: &[f32], distance: f64) -> f32 {
    let above = above(distance);
    list.last().map_or(above, |&before| above.max(before))
}
