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
    /// Whether the pass met its limit of work: from there on, levels were measured one by one, and
    /// steps between two of them state the error of the coarser one.
    pub ends_in_ladder: bool,
}

impl StepErrors {
    pub(crate) fn with_capacity(steps: usize) -> Self {
        let [error, rms] = [0; 2].map(|_| Vec::with_capacity(steps));
        Self { error, rms, ends_in_ladder: false }
    }

    /// Raises each distance to that of the same step in `other`, where that is larger.
    pub(crate) fn raise(&mut self, other: &Self) {
        let raise_all = |distances: &mut [f32], other: &[f32]| {
            distances.iter_mut().zip(other).for_each(|(d, &other)| *d = d.max(other));
        };
        raise_all(&mut self.error, &other.error);
        raise_all(&mut self.rms, &other.rms);
        self.ends_in_ladder |= other.ends_in_ladder;
    }

    /// Adds a step: distances are rounded up and kept from falling.
    pub(crate) fn push(&mut self, error: f64, rms: f64) {
        self.error.push(rounded_up_from_last(&self.error, error));
        self.rms.push(rounded_up_from_last(&self.rms, rms));
    }
}

fn rounded_up_from_last(distances: &[f32], distance: f64) -> f32 {
    let rounded = round_up(distance);
    distances.last().map_or(rounded, |&last| rounded.max(last))
}

/// Returns the least `f32` that is not below a distance.
pub(crate) fn round_up(distance: f64) -> f32 {
    let nearest = distance as f32;
    let rounded = if f64::from(nearest) < distance { nearest.next_up() } else { nearest };
    // Infinity means a missing surface: a finite distance that is too large for `f32` is not that.
    if distance.is_finite() { rounded.min(f32::MAX) } else { rounded }
}
