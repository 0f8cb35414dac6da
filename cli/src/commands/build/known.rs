//! Knowledge that simplifying a scene takes.

use crate::paints::Paints;
use lodc_formats::{Document, Limits};
use lodc_simplify::Weights;

/// Knowledge of a scene besides its meshes.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    /// Its colours, where a metric sees them.
    pub(crate) paints: Option<&'a Paints>,
    /// By object the vertices that stay. An object without a list has none.
    pub(crate) locked: &'a [Vec<bool>],
    /// By object and submesh the weights of materials. An object without a list has those of its
    /// options.
    pub(crate) weights: &'a [Vec<Weights>],
    pub(crate) document: &'a Document,
    pub(crate) limits: Limits,
}
