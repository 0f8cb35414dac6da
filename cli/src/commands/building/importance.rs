//! Resolves options of importance (`--lock` and weights of parts) against the scene: which vertices
//! are locked, and how much each object's errors weigh.

use crate::exit::Outcome;
use crate::importance::ImportanceArgs;
use crate::jobs::Parts;
use lodc::pipeline::{Importance, PaintedValues};
use lodc_formats::Scene;
use lodc_formats::import::ImportOptions;
use lodc_simplify::Options;
use std::path::Path;

/// The locked vertices, the weights and the painted importance of a scene. `options` are those of
/// the objects.
///
/// # Errors
/// If a lock or a part names nothing in the scene, the stored document is damaged, or what is
/// painted is not there or cannot be read.
pub(crate) fn importance(
    (input, import): (&Path, &ImportOptions),
    scene: &Scene,
    options: &[Options],
    args: &ImportanceArgs,
    parts: Parts<'_>,
) -> Outcome<Importance> {
    parts.check_names(scene)?;
    let mut locked = args.locked(scene)?;
    parts.lock_vertices(scene, &mut locked)?;
    let painted = match args.painted() {
        Some(painted) => painted.read(input, import, scene)?,
        None => PaintedValues::default(),
    };
    Ok(Importance { locked, weights: parts.material_weights(scene, options)?, painted })
}
