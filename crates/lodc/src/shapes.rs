//! The shapes of an object over which its errors are measured: in its placements, and in animated
//! poses.

use crate::LodObject;
use lodc_formats::{Document, FormatError, Limits, ObjectInfo, scene_motion};
use lodc_scene::ObjectShapes;

/// Returns for each object of a file the shapes that its errors are the largest over: in the
/// placements that stand for all, then in the poses of its description. Each gives the positions of
/// the vertices of the object's mesh, or of any other mesh with its attributes, in the object's
/// units. The error of such a mesh is the largest distance between both in any of these shapes.
///
/// # Errors
/// If the stored document is damaged.
pub fn stated_shapes(
    objects: &[LodObject],
    document: &Document,
    limits: &Limits,
) -> Result<Vec<ObjectShapes>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let motion = scene_motion(document, &infos, limits)?;
    let shapes = |(number, object): (usize, &LodObject)| {
        motion.shapes(object.simplified.mesh(), number, &object.info.poses)
    };
    Ok(objects.iter().enumerate().map(shapes).collect())
}
