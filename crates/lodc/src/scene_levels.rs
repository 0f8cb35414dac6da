//! Joins the levels of a file's objects into levels of the scene, ordered by world error, to choose
//! from.

use crate::LodObject;
use lodc_formats::{Document, FormatError, Limits, ObjectInfo, scene_graph};
use lodc_scene::{Arrangement, Graph};
use lodc_select::{ObjectLevels, SceneLevels};

/// The levels of a scene: those of all its objects, placed as the document has them in the rest
/// pose.
///
/// # Errors
/// If the stored document is damaged.
pub fn scene_levels<'a>(
    objects: &'a [LodObject],
    document: &Document,
    limits: &Limits,
) -> Result<SceneLevels<'a>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let graph = match objects {
        // Where objects are matters only for choosing among several.
        [] | [_] => Graph::of_objects(objects.len() as u32),
        _ => scene_graph(document, &infos, limits)?,
    };
    let scene = Arrangement::new(&graph, &graph.rest_pose(), objects.len());
    let object = |o: &'a LodObject| ObjectLevels {
        name: &o.info.name,
        simplified: &o.simplified,
        scale: o.info.world_scale,
    };
    Ok(SceneLevels::new(objects.iter().map(object).collect(), scene))
}
