//! Knowledge that simplifying a scene takes.

use crate::exit::Outcome;
use crate::importance::ImportanceArgs;
use crate::paints::Paints;
use crate::parts::PartArgs;
use lodc_formats::{Document, Limits, Scene};
use lodc_simplify::{Options, Weights};

/// Knowledge of a scene besides its meshes.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    /// Its colours, where a metric sees them.
    pub(crate) paints: Option<&'a Paints>,
    pub(crate) importance: &'a Importance,
    pub(crate) document: &'a Document,
    pub(crate) limits: Limits,
}

/// Parts of a scene that matter more or less than others.
pub(crate) struct Importance {
    /// By object the vertices that stay. An object without a list has none.
    pub(super) locked: Vec<Vec<bool>>,
    /// By object and submesh the weights of materials. An object without a list has those of its
    /// options.
    pub(super) weights: Vec<Vec<Weights>>,
}

impl Importance {
    /// Finds the parts. `options` are those of the objects.
    ///
    /// # Errors
    /// If a lock or a part names nothing in the scene, or the stored document is damaged.
    pub(crate) fn new(
        scene: &Scene,
        options: &[Options],
        args: &ImportanceArgs,
        parts: &PartArgs,
    ) -> Outcome<Self> {
        parts.check(scene)?;
        let mut locked = args.locked(scene)?;
        parts.lock(scene, &mut locked)?;
        Ok(Self { locked, weights: parts.weights(scene, options)? })
    }
}
