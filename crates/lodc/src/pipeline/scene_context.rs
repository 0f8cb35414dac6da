//! What the simplifier uses of a scene besides its meshes.

use super::{PaintedValues, SceneColours};
use lodc_formats::{Document, Limits};
use lodc_simplify::Weights;

/// What the simplifier uses of a scene besides its meshes.
#[derive(Clone, Copy)]
pub(crate) struct SceneContext<'a> {
    /// Its colours, if a metric uses them.
    pub(crate) colours: Option<&'a SceneColours>,
    /// Vertices that stay, weights of materials, and what is painted.
    pub(crate) importance: &'a Importance,
    /// Its document: nodes and materials.
    pub(crate) document: &'a Document,
    /// How many poses of its animations collapses are priced in, at most; 0: at rest alone, without
    /// morph targets, too.
    pub(crate) poses: usize,
    /// Limits on reading the document.
    pub(crate) limits: Limits,
}

/// Vertices that stay, weights of materials, and what is painted.
#[derive(Clone, Debug, Default)]
pub struct Importance {
    /// By object and vertex: whether it stays. The list of an object without such vertices is
    /// empty.
    pub locked: Vec<Vec<bool>>,
    /// By object and submesh: the weights of attributes. An object with an empty list has those of
    /// its options.
    pub weights: Vec<Vec<Weights>>,
    /// How much distances count where.
    pub painted: PaintedValues,
}
