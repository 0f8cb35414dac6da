//! Knowledge that simplifying a scene takes.

use super::Paints;
use lodc_formats::{Document, Limits};
use lodc_simplify::Weights;

/// Knowledge of a scene besides its meshes.
#[derive(Clone, Copy)]
pub struct SceneContext<'a> {
    /// Its colours, where a metric sees them.
    pub paints: Option<&'a Paints>,
    /// Parts that matter more or less than others.
    pub importance: &'a Importance,
    /// Its nodes.
    pub document: &'a Document,
    /// Limits on reading them.
    pub limits: Limits,
}

/// Parts of a scene that matter more or less than others.
#[derive(Clone, Debug, Default)]
pub struct Importance {
    /// By object the vertices that stay. An object without a list has none.
    pub locked: Vec<Vec<bool>>,
    /// By object and submesh the weights of materials. An object without a list has those of its
    /// options.
    pub weights: Vec<Vec<Weights>>,
}
