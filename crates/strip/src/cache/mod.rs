//! Strips that reuse a vertex cache.

use crate::{CacheModel, Effort, StripSet};
use lodc_mesh::Mesh;

/// What cache-aware strips are made for.
#[derive(Clone, Copy, Debug, Default)]
pub struct CacheOptions {
    /// The cache.
    pub model: CacheModel,
    /// How long to search.
    pub effort: Effort,
}

/// Makes strips.
#[must_use]
pub fn cache(mesh: &Mesh, options: &CacheOptions) -> StripSet {
    crate::stripe(mesh, options.effort)
}
