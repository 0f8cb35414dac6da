//! An object as levels are chosen for it: its levels, and what limits them.

use lodc_mesh::{CollapseSequence, Lod};

/// An object to choose a level of detail for.
#[derive(Clone, Copy, Debug)]
pub struct Candidate<'a> {
    /// Its name, for warnings.
    pub name: &'a str,
    /// Its levels.
    pub collapses: &'a CollapseSequence,
    /// World units per mesh unit.
    pub scale: f64,
    /// Diagonal of its bounding box, in mesh units.
    pub diagonal: f64,
    /// The coarsest level that keeps what is locked
    /// ([`Simplified::coarsest`](lodc_mesh::Simplified::coarsest)).
    pub coarsest: Lod,
    /// The farthest that quantising moves a vertex in the file that levels are chosen for, in mesh
    /// units: it counts as part of a level's error.
    pub rounding: f64,
}

impl Candidate<'_> {
    /// World units per mesh unit, a finite number of at least 0.
    pub(crate) fn world_scale(&self) -> f64 {
        if self.scale.is_finite() { self.scale.abs() } else { 1.0 }
    }

    /// The coarsest level that has a triangle and keeps what is locked.
    pub(crate) fn last(&self) -> Lod {
        self.coarsest.min(self.collapses.last_visible())
    }

    /// What that level is the last of, for messages.
    pub(crate) fn why_last(&self) -> &'static str {
        match self.coarsest < self.collapses.last_visible() {
            true => "keeps what is locked",
            false => "has a triangle",
        }
    }
}
