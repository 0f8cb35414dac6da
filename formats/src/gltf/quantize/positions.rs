//! Chooses the grid of each mesh's positions: one step in world space for all, and offsets that are
//! multiples of it, so that vertices of touching parts stay at one position.

use super::grid::{Bounds, Grid, last_number, short};
use super::{Subject, primitives, skins};
use crate::gltf::graph::scene_graph;
use crate::gltf::json::Object;
use crate::{Document, FormatError, Limits, ObjectInfo};
use lodc_mesh::{Attribute, Component, DisjointSets, Mesh, Semantic};
use lodc_scene::Arrangement;
use std::collections::BTreeMap;

/// The most steps that a difference of positions may have.
const MOST_OFFSET: f64 = 32_767.0;
/// The most steps that the side of a box may have: one less than fits, since grids begin at
/// multiples of their step.
const MOST_STEPS: f64 = 65_534.0;

/// The grid of each object's positions; none where they stay as they are. The longest side of the
/// scene has 2^bits − 2 steps; no object has fewer than 2^(bits/2 + 1).
///
/// # Errors
/// If the document is damaged.
pub(super) fn grids(
    document: &Document,
    root: &Object,
    subjects: &[Subject<'_>],
    bits: u8,
) -> Result<Vec<Option<Grid<3>>>, FormatError> {
    let of_subject = |s: &Subject<'_>| {
        let mut all = bounds(&s.geometry);
        s.next.iter().for_each(|next| all.join(&bounds(next)));
        all
    };
    let boxes: Vec<Bounds<3>> = subjects.iter().map(of_subject).collect();
    let step = scene_size(document, subjects, &boxes)? / (last_number(bits) - 1.0);
    let groups = groups(root, subjects);
    let mut grids = vec![None; subjects.len()];
    for group in groups.iter().filter(|g| g.iter().all(|&o| is_movable(root, subjects, o))) {
        let mut all = Bounds::EMPTY;
        group.iter().for_each(|&o| all.join(&boxes[o]));
        let world_step = |&o: &usize| {
            let fewest = f64::from(2u32 << (bits / 2));
            (step / scale(&subjects[o])).min(boxes[o].longest() / fewest)
        };
        let finest =
            group.iter().map(world_step).filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
        let step = short(finest.max(all.longest() / MOST_STEPS));
        let fits = |&o: &usize| largest_offset(&subjects[o].geometry) <= MOST_OFFSET * step;
        if step.is_finite() && step >= f64::from(f32::MIN_POSITIVE) && group.iter().all(fits) {
            group.iter().for_each(|&o| grids[o] = Some(Grid::aligned(&all, step)));
        }
    }
    Ok(grids)
}

/// The longest side of the scene at rest. What has a skin counts by its size alone.
fn scene_size(
    document: &Document,
    subjects: &[Subject<'_>],
    boxes: &[Bounds<3>],
) -> Result<f64, FormatError> {
    let infos: Vec<&ObjectInfo> = subjects.iter().map(|s| s.info).collect();
    let graph = scene_graph(document, &infos, &Limits::DEFAULT)?;
    let scene = Arrangement::new(&graph, &graph.rest_pose(), subjects.len());
    let mut all = Bounds::EMPTY;
    for placement in scene.placements().iter().filter(|p| p.joints.is_empty()) {
        for corner in boxes[placement.object].corners() {
            all.add(placement.transform.transform_point3(corner.into()).to_array());
        }
    }
    let world_size = |(s, b): (&Subject<'_>, &Bounds<3>)| b.longest() * scale(s);
    let largest = subjects.iter().zip(boxes).map(world_size).fold(0.0, f64::max);
    let scene_box_size = all.longest();
    Ok(if scene_box_size.is_finite() { scene_box_size.max(largest) } else { largest })
}

/// Objects that need one grid because a skin's matrices hold its transform for all of them.
fn groups(root: &Object, subjects: &[Subject<'_>]) -> Vec<Vec<usize>> {
    let mut joined = DisjointSets::new(subjects.len());
    let mut first: BTreeMap<usize, u32> = BTreeMap::new();
    for (o, subject) in (0..).zip(subjects) {
        for matrices in showing(root, subject.mesh).filter_map(|n| skins::matrices(root, n)) {
            joined.join(*first.entry(matrices).or_insert(o), o);
        }
    }
    let mut groups: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for o in 0..subjects.len() {
        groups.entry(joined.find(o as u32)).or_default().push(o);
    }
    groups.into_values().collect()
}

/// Returns whether everything that shows an object can be given a transform: nodes without
/// instances, and skins. Positions that are integers stay, and so do those that points or lines of
/// the same mesh are beside.
fn is_movable(root: &Object, subjects: &[Subject<'_>], object: usize) -> bool {
    let subject = &subjects[object];
    let written = |mesh: usize| subjects.iter().any(|s| s.mesh == mesh);
    let plain = |a: &Attribute| {
        a.semantic != Semantic::Position
            || (a.morph_target.is_some() && a.component == Component::F32)
    };
    let can_move = |node: &Object| {
        let instanced = node.extension("EXT_mesh_gpu_instancing").is_some();
        !instanced && (!node.contains_key("skin") || skins::is_movable(root, node, written))
    };
    primitives(root, subject.mesh).len() == subject.primitives.len()
        && subject.geometry.attributes().iter().all(plain)
        && showing(root, subject.mesh).all(can_move)
}

/// The nodes that show a mesh of the document.
fn showing(root: &Object, mesh: usize) -> impl Iterator<Item = &Object> {
    let shows = move |n: &&Object| n["mesh"].as_index() == Some(mesh);
    root.entries("nodes").filter(shows)
}

/// World units per mesh unit.
fn scale(subject: &Subject<'_>) -> f64 {
    let scale = subject.info.world_scale;
    if scale.is_finite() && scale > 0.0 { scale } else { 1.0 }
}

fn bounds(mesh: &Mesh) -> Bounds<3> {
    let mut bounds = Bounds::EMPTY;
    mesh.positions().iter().for_each(|&p| bounds.add(p.map(f64::from)));
    bounds
}

/// The largest number among the differences of positions that morph targets have; infinite if one
/// is not finite.
fn largest_offset(mesh: &Mesh) -> f64 {
    let moved = mesh.attributes().iter().filter(|a| a.semantic == Semantic::Position);
    let numbers =
        moved.flat_map(|a| a.bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)));
    let size = |v: f32| if v.is_finite() { f64::from(v.abs()) } else { f64::INFINITY };
    numbers.map(size).fold(0.0, f64::max)
}
