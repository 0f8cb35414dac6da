//! Joins the levels of a file's objects into levels of the scene, ordered by error in world units,
//! to choose from.

use crate::LodObject;
use lodc_formats::{Document, FormatError, Limits, ObjectInfo, scene_motion};
use lodc_select::{ObjectLevels, SceneLevels};

/// The levels of a scene: those of all its objects, placed as the document has them at rest, or
/// where an animation shows them larger.
///
/// # Errors
/// If the stored document is damaged.
pub fn scene_levels<'a>(
    objects: &'a [LodObject],
    document: &Document,
    limits: &Limits,
) -> Result<SceneLevels<'a>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let motion = scene_motion(document, &infos, limits)?;
    let object = |(number, o): (usize, &'a LodObject)| ObjectLevels {
        name: &o.info.name,
        simplified: &o.simplified,
        scale: o.info.world_scale,
        unevenness: motion.measured_placements(o.simplified.mesh(), number).unevenness,
        rounding: 0.0,
    };
    let levels = objects.iter().enumerate().map(object).collect();
    Ok(SceneLevels::new(levels, motion.largest()))
}
