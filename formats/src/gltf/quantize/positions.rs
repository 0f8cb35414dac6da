//! Chooses the grid of each mesh's positions: one step in world space for all, and offsets that are
//! multiples of it, so that vertices of touching parts stay at one position.

use super::grid::{Bounds, Grid, last_number, rounded_to_seven_digits};
use super::{WrittenObject, primitives, skins};
use crate::gltf::extensions::INSTANCING;
use crate::gltf::graph::scene_graph;
use crate::gltf::json::Object;
use crate::{Document, FormatError, Limits, ObjectInfo};
use lodc_mesh::{Attribute, Component, DisjointSets, Mesh, Semantic};
use lodc_scene::{Arrangement, follows_joints};
use std::collections::BTreeMap;

/// Largest number of steps by which a morph target moves a position: they are stored as `i16`.
const MAX_MORPH_STEPS: f64 = 32_767.0;
/// Largest number of steps along the side of a box: one less than a `u16` holds, since grids begin
/// at multiples of their step.
const MAX_BOX_STEPS: f64 = 65_534.0;

/// The grid of each object's positions; none where they stay as they are. The longest side of the
/// scene has 2^bits − 2 steps; no object has fewer than 2^(bits/2 + 1).
///
/// # Errors
/// If the document is damaged.
pub(super) fn grids(
    document: &Document,
    root: &Object,
    written_objects: &[WrittenObject<'_>],
    bits: u8,
) -> Result<Vec<Option<Grid<3>>>, FormatError> {
    let box_of = |written: &WrittenObject<'_>| {
        let mut all = bounds(&written.geometry);
        // What a level morphs to is written as differences from its positions, and needs the room.
        written.geomorph_target.iter().for_each(|target| all.join(&bounds(target)));
        all
    };
    let boxes: Vec<Bounds<3>> = written_objects.iter().map(box_of).collect();
    let world_step = scene_size(document, written_objects, &boxes)? / (last_number(bits) - 1.0);
    let groups = groups(root, written_objects);
    let mut grids = vec![None; written_objects.len()];
    let reasons = reasons_to_stay(root, written_objects);
    let is_movable = |&o: &usize| reasons[o].is_none() && is_movable(root, written_objects, o);
    for group in groups.iter().filter(|group| group.iter().all(is_movable)) {
        let mut all = Bounds::EMPTY;
        group.iter().for_each(|&o| all.join(&boxes[o]));
        // In mesh units.
        let mesh_step = |&o: &usize| {
            let min_steps = f64::from(2u32 << (bits / 2));
            (world_step / scale(&written_objects[o])).min(boxes[o].longest() / min_steps)
        };
        let finest =
            group.iter().map(mesh_step).filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
        let step = rounded_to_seven_digits(finest.max(all.longest() / MAX_BOX_STEPS));
        let fits =
            |&o: &usize| largest_morph(&written_objects[o].geometry) <= MAX_MORPH_STEPS * step;
        if step.is_finite() && step >= f64::from(f32::MIN_POSITIVE) && group.iter().all(fits) {
            group.iter().for_each(|&o| grids[o] = Some(Grid::aligned(&all, step)));
        }
    }
    Ok(grids)
}

/// The longest side of the scene at rest, in world units. Objects with a skin count by their own
/// size, since their joints may place them anywhere.
fn scene_size(
    document: &Document,
    written_objects: &[WrittenObject<'_>],
    boxes: &[Bounds<3>],
) -> Result<f64, FormatError> {
    let infos: Vec<&ObjectInfo> = written_objects.iter().map(|written| written.info).collect();
    let graph = scene_graph(document, &infos, &Limits::DEFAULT)?;
    let scene = Arrangement::new(&graph, &graph.rest_pose(), written_objects.len());
    let mut all = Bounds::EMPTY;
    for placement in scene.placements().iter().filter(|p| p.joints.is_empty()) {
        for corner in boxes[placement.object].corners() {
            all.add(placement.transform.transform_point3(corner.into()).to_array());
        }
    }
    let world_size = |(written, b): (&WrittenObject<'_>, &Bounds<3>)| b.longest() * scale(written);
    let largest = written_objects.iter().zip(boxes).map(world_size).fold(0.0, f64::max);
    let scene_box_size = all.longest();
    Ok(if scene_box_size.is_finite() { scene_box_size.max(largest) } else { largest })
}

/// Objects that need one grid because a skin's matrices hold its transform for all of them.
fn groups(root: &Object, written_objects: &[WrittenObject<'_>]) -> Vec<Vec<usize>> {
    let mut joined = DisjointSets::new(written_objects.len());
    let mut first: BTreeMap<usize, u32> = BTreeMap::new();
    for (o, written) in (0..).zip(written_objects) {
        for matrices in nodes_showing(root, written.mesh).filter_map(|n| skins::matrices(root, n)) {
            joined.join(*first.entry(matrices).or_insert(o), o);
        }
    }
    let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for o in 0..written_objects.len() {
        groups.entry(joined.find(o as u32)).or_default().push(o);
    }
    groups.into_values().collect()
}

/// Objects that no matrices of a skin can place: some of their vertices have no weight for any of
/// its joints, so that these follow the node. With them all that share the matrices.
fn lacking_joints(root: &Object, written_objects: &[WrittenObject<'_>]) -> Vec<bool> {
    let lacks = |o: &usize| {
        let written = &written_objects[*o];
        let skins = nodes_showing(root, written.mesh).filter_map(|n| n["skin"].as_index());
        let joints = skins.map(|skin| root["skins"][skin]["joints"].list().len()).min();
        joints.is_some_and(|joints| !follows_joints(&written.geometry, joints))
    };
    let mut lacking = vec![false; written_objects.len()];
    for group in groups(root, written_objects) {
        if group.iter().any(lacks) {
            group.iter().for_each(|&o| lacking[o] = true);
        }
    }
    lacking
}

/// For each object why its positions stay as they are; none also of those whose numbers or other
/// primitives say so themselves.
pub(super) fn reasons_to_stay(
    root: &Object,
    written_objects: &[WrittenObject<'_>],
) -> Vec<Option<&'static str>> {
    let lacks_joints = lacking_joints(root, written_objects);
    let reason = |(written, lacks_joints): (&WrittenObject<'_>, bool)| {
        let mut nodes = nodes_showing(root, written.mesh);
        if lacks_joints {
            Some("vertices without weights do not follow the joints that would undo it")
        } else if nodes.any(|node| node.extension(INSTANCING).is_some()) {
            Some("its instances have no node of their own that could undo it")
        } else {
            None
        }
    };
    written_objects.iter().zip(lacks_joints).map(reason).collect()
}

/// Returns whether there is something that shows an object, and the skins of all of that can be
/// given a transform; [`reasons_to_stay`] is about the rest. Positions stay that are stored as
/// integers, and those of meshes that also have points or lines.
fn is_movable(root: &Object, written_objects: &[WrittenObject<'_>], object: usize) -> bool {
    let written = &written_objects[object];
    let is_written = |mesh: usize| written_objects.iter().any(|written| written.mesh == mesh);
    // Of positions outside morph targets, integers alone are attributes.
    let is_float_or_other = |a: &Attribute| {
        a.semantic != Semantic::Position
            || (a.morph_target.is_some() && a.component == Component::F32)
    };
    let can_move =
        |node: &Object| !node.contains_key("skin") || skins::is_movable(root, node, is_written);
    primitives(root, written.mesh).len() == written.primitives.len()
        && written.geometry.attributes().iter().all(is_float_or_other)
        && nodes_showing(root, written.mesh).next().is_some()
        && nodes_showing(root, written.mesh).all(can_move)
}

/// The nodes that show a mesh of the document.
fn nodes_showing(root: &Object, mesh: usize) -> impl Iterator<Item = &Object> {
    let shows = move |n: &&Object| n["mesh"].as_index() == Some(mesh);
    root.entries("nodes").filter(shows)
}

/// World units per mesh unit.
fn scale(written: &WrittenObject<'_>) -> f64 {
    let scale = written.info.world_scale;
    if scale.is_finite() && scale > 0.0 { scale } else { 1.0 }
}

fn bounds(mesh: &Mesh) -> Bounds<3> {
    let mut bounds = Bounds::EMPTY;
    mesh.positions().iter().for_each(|&p| bounds.add(p.map(f64::from)));
    bounds
}

/// The largest number by which a morph target moves a position; infinite if one is not finite.
fn largest_morph(mesh: &Mesh) -> f64 {
    let moved = mesh.attributes().iter().filter(|a| a.semantic == Semantic::Position);
    let numbers =
        moved.flat_map(|a| a.bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)));
    let size = |v: f32| if v.is_finite() { f64::from(v.abs()) } else { f64::INFINITY };
    numbers.map(size).fold(0.0, f64::max)
}
