//! Resolves options of importance (`--lock` and weights of parts) against the scene: which vertices
//! are locked, and how much each object's errors weigh.

use crate::exit::Outcome;
use crate::importance::ImportanceArgs;
use crate::jobs::Parts;
use lodc::pipeline::Importance;
use lodc_formats::Scene;
use lodc_simplify::Options;

/// The locked vertices and the weights of a scene. `options` are those of the objects.
///
/// # Errors
/// If a lock or a part names nothing in the scene, or the stored document is damaged.
pub(crate) fn importance(
    scene: &Scene,
    options: &[Options],
    args: &ImportanceArgs,
    parts: Parts<'_>,
) -> Outcome<Importance> {
    parts.check_names(scene)?;
    let mut locked = args.locked(scene)?;
    parts.lock_vertices(scene, &mut locked)?;
    Ok(Importance { locked, weights: parts.material_weights(scene, options)? })
}
