//! The shapes of an object over which its errors are measured: in its placements, and in animated
//! poses.

use crate::LodObject;
use lodc_formats::{Document, FormatError, Limits, ObjectInfo, scene_motion};
use lodc_mesh::{Attribute, Mesh, PoseKey, Semantic};
use lodc_scene::{ObjectShapes, Shape};
use std::collections::BTreeSet;
use std::ops::Range;

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
    let stated = |object: &LodObject| object.info.poses.clone();
    shapes(objects, document, limits, stated)
}

/// Returns for each object of a file its shapes with each morph target at weight 1, by itself, that
/// its errors are not over: those [of pose keys](ObjectShapes::of_pose_keys).
///
/// # Errors
/// If the stored document is damaged.
pub fn target_shapes(
    objects: &[LodObject],
    document: &Document,
    limits: &Limits,
) -> Result<Vec<ObjectShapes>, FormatError> {
    let targets = |object: &LodObject| {
        let deltas = object.simplified.mesh().attributes().iter();
        let deltas = deltas.filter(|a| a.semantic == Semantic::Position);
        let targets: BTreeSet<u32> = deltas.filter_map(|a| a.morph_target).collect();
        let pose_keys = targets.into_iter().map(PoseKey::Target);
        pose_keys.filter(|p| !object.info.poses.contains(p)).collect()
    };
    shapes(objects, document, limits, targets)
}

/// Returns for each object its shapes in all placements, and in some pose keys.
fn shapes(
    objects: &[LodObject],
    document: &Document,
    limits: &Limits,
    pose_keys: impl Fn(&LodObject) -> Vec<PoseKey>,
) -> Result<Vec<ObjectShapes>, FormatError> {
    let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
    let motion = scene_motion(document, &infos, limits)?;
    let of_object = |(number, object): (usize, &LodObject)| {
        motion.shapes(object.simplified.mesh(), number, &pose_keys(object))
    };
    Ok(objects.iter().enumerate().map(of_object).collect())
}

/// The largest distance between some vertices of two meshes, over all shapes.
pub(crate) fn farthest_vertex(shapes: &[Shape], a: &Mesh, b: &Mesh, moving: &Range<u32>) -> f64 {
    let in_shape = |shape: &Shape| {
        let (a, b) = (shape.of(a), shape.of(b));
        let between = |v: u32| {
            let [p, q] = [a[v as usize], b[v as usize]].map(|p| p.map(f64::from));
            (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
        };
        moving.clone().map(between).fold(0.0, f64::max)
    };
    shapes.iter().map(in_shape).fold(0.0, f64::max)
}

/// Returns whether joints or morph targets move a mesh.
#[must_use]
pub fn bends(mesh: &Mesh) -> bool {
    let moves =
        |a: &Attribute| matches!(a.semantic, Semantic::Joints(_)) || a.morph_target.is_some();
    mesh.attributes().iter().any(moves)
}
