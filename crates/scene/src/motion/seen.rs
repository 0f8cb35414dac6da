//! The shapes of an object that simplification looks at: at rest, with each of its morph targets,
//! and in poses.

use super::{Motion, ObjectShapes};
use crate::placement::Placement;
use crate::posed::{Streams, vector};
use glam::{DVec3, Vec3};
use lodc_mesh::{Attribute, Mesh, PoseKey, Semantic, SplitMix64};
use std::collections::{BTreeMap, BTreeSet};

/// The most shapes with morph targets that are looked at. Where more targets move the same places,
/// those of the largest deltas count. Chosen by hand.
pub const MAX_TARGET_SHAPES: usize = 96;
/// Deltas of normals that are shorter turn nothing. Chosen by hand: about the rounding of normals
/// in eight bits.
const MIN_NORMAL_DELTA: f64 = 0.01;
/// Deltas of less than this share of the object's diagonal move nothing. Chosen by hand: about the
/// rounding of deltas in sixteen bits.
const MIN_DELTA_SHARE: f64 = 1e-5;
/// Shapes are the same if no distance within one differs by more than this share of the object's
/// diagonal. Chosen by hand, between rounding and what is seen.
const SAME_SHARE: f64 = 1e-4;
/// Pairs of vertices, chosen at random, whose distances are compared.
const COMPARED_PAIRS: usize = 1024;

/// The shapes of an object that is moved by joints or morph targets. Each is a position for every
/// vertex, in mesh units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeenPositions {
    /// As it was modelled, with the morph weights that it has by default. Empty if these are 0.
    pub at_rest: Vec<[f32; 3]>,
    /// The normals there. Empty if they are those of the mesh.
    pub normals_at_rest: Vec<[f32; 3]>,
    /// With morph targets at weight 1, each by itself; targets that move places apart from each
    /// other share a shape.
    pub targets: Vec<TargetShape>,
    /// In placements that give it another shape.
    pub placements: Vec<Vec<[f32; 3]>>,
    /// In poses of animations.
    pub poses: Vec<Vec<[f32; 3]>>,
}

/// The shape of an object with morph targets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetShape {
    /// One for each vertex.
    pub positions: Vec<[f32; 3]>,
    /// One for each vertex, of any length; empty if they are those at rest.
    pub normals: Vec<[f32; 3]>,
}

impl Motion {
    /// Returns the shapes of an object in which collapses are priced: those at rest, of every morph
    /// target, and in those of `pose_keys` that are moments of animations. None if neither joints
    /// nor morph targets move it.
    #[must_use]
    pub fn seen(&self, mesh: &Mesh, object: usize, pose_keys: &[PoseKey]) -> Option<SeenPositions> {
        let [deltas, normal_deltas] =
            [Semantic::Position, Semantic::Normal].map(|s| deltas(mesh, &s));
        let is_skinned = self.rest.of(object).any(|placement| !placement.joints.is_empty());
        if deltas.is_empty() && normal_deltas.is_empty() && !is_skinned {
            return None;
        }
        let is_moment = |p: &&PoseKey| matches!(p, PoseKey::Moment { .. });
        let moments: Vec<PoseKey> = pose_keys.iter().filter(is_moment).copied().collect();
        let shapes = self.shapes(mesh, object, &moments);
        let first = self.measured_placements(mesh, object).placements.into_iter().next();
        let weights = first.map_or_else(Vec::new, |at| at.placement.weights.to_vec());
        let mut seen = SeenPositions::default();
        let at_rest = at_rest(mesh, &weights);
        let diagonal = diagonal(&at_rest);
        let others = other_shapes(mesh, &shapes, &at_rest, diagonal);
        [seen.placements, seen.poses] = others;
        let normals = normals_at_rest(mesh, &weights);
        let targets = Targets { deltas, normal_deltas, weights: &weights };
        seen.targets = target_shapes(mesh, &targets, &at_rest, &normals, diagonal);
        let is_turned = !targets.normal_deltas.is_empty() && weights.iter().any(|w| *w != 0.0);
        if is_turned {
            seen.normals_at_rest = normals.into_iter().map(to_single).collect();
        }
        if at_rest.iter().zip(mesh.positions()).any(|(p, raw)| to_single(*p) != *raw) {
            seen.at_rest = at_rest.into_iter().map(to_single).collect();
        }
        Some(seen)
    }
}

fn to_single(p: DVec3) -> [f32; 3] {
    p.as_vec3().to_array()
}

/// The deltas that each morph target has of positions or normals.
fn deltas<'a>(mesh: &'a Mesh, semantic: &Semantic) -> BTreeMap<u32, Vec<&'a Attribute>> {
    let mut deltas: BTreeMap<u32, Vec<&Attribute>> = BTreeMap::new();
    for a in mesh.attributes().iter().filter(|a| a.semantic == *semantic) {
        if let Some(target) = a.morph_target {
            deltas.entry(target).or_default().push(a);
        }
    }
    deltas
}

/// The positions as modelled, with morph weights.
fn at_rest(mesh: &Mesh, weights: &[f64]) -> Vec<DVec3> {
    let placement = Placement { weights: weights.into(), ..Placement::as_modelled(0) };
    let streams = Streams::of(mesh, &placement);
    (0..mesh.vertex_count() as u32).map(|v| streams.position(mesh, v)).collect()
}

/// The normals as modelled, with morph weights; zero where a vertex has none.
fn normals_at_rest(mesh: &Mesh, weights: &[f64]) -> Vec<DVec3> {
    let placement = Placement { weights: weights.into(), ..Placement::as_modelled(0) };
    let streams = Streams::of(mesh, &placement);
    let normal = |v: u32| streams.normal(mesh, v).filter(|n| n.is_finite()).unwrap_or_default();
    (0..mesh.vertex_count() as u32).map(normal).collect()
}

fn diagonal(positions: &[DVec3]) -> f64 {
    let (low, high) = positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    if positions.is_empty() { 0.0 } else { (high - low).length() }
}

/// The shapes of placements, and those of pose keys, that are others than that at rest, and than
/// each other.
fn other_shapes(
    mesh: &Mesh,
    shapes: &ObjectShapes,
    at_rest: &[DVec3],
    diagonal: f64,
) -> [Vec<Vec<[f32; 3]>>; 2] {
    let mut random = SplitMix64::new(1);
    let vertices = mesh.vertex_count();
    let mut vertex = || random.below(vertices.max(1));
    let pairs: Vec<[usize; 2]> = (0..COMPARED_PAIRS).map(|_| [vertex(), vertex()]).collect();
    let edges = mesh.triangles().iter().flat_map(|t| {
        let [a, b, c] = t.map(|v| v as usize);
        [[a, b], [b, c], [c, a]]
    });
    let compared: Vec<[usize; 2]> = pairs.into_iter().chain(edges).collect();
    let mut found: [Vec<Vec<[f32; 3]>>; 2] = Default::default();
    let placements = shapes.of_placements().iter().map(|shape| (shape, 0));
    for (shape, kind) in placements.chain(shapes.of_pose_keys().iter().map(|shape| (shape, 1))) {
        let positions = shape.of(mesh);
        let at = |v: usize| Vec3::from(positions[v]).as_dvec3();
        let is_same = |other: &dyn Fn(usize) -> DVec3| {
            let distance = |p: &dyn Fn(usize) -> DVec3, [a, b]: [usize; 2]| p(a).distance(p(b));
            let difference = |&pair| (distance(&at, pair) - distance(other, pair)).abs();
            compared.iter().all(|pair| difference(pair) <= SAME_SHARE * diagonal)
        };
        let is_known = is_same(&|v| at_rest[v])
            || found.iter().flatten().any(|known| is_same(&|v| Vec3::from(known[v]).as_dvec3()));
        if !is_known {
            found[kind].push(positions.into_owned());
        }
    }
    found
}

/// The morph targets of a mesh.
struct Targets<'a> {
    /// The deltas of positions of each.
    deltas: BTreeMap<u32, Vec<&'a Attribute>>,
    /// The deltas of normals of each.
    normal_deltas: BTreeMap<u32, Vec<&'a Attribute>>,
    /// The weights by default.
    weights: &'a [f64],
}

impl Targets<'_> {
    /// The vertices that a target moves or turns by more than `least`, and by how much, beyond what
    /// its default weight does.
    fn changed(
        &self,
        streams: Option<&Vec<&Attribute>>,
        target: u32,
        vertices: usize,
        least: f64,
    ) -> Vec<(usize, DVec3)> {
        let Some(streams) = streams else { return Vec::new() };
        let weight = 1.0 - self.weights.get(target as usize).copied().unwrap_or(0.0);
        (0..vertices)
            .map(|v| (v, weight * streams.iter().map(|a| vector(a, v as u32)).sum::<DVec3>()))
            .filter(|(_, delta)| delta.is_finite() && delta.length() > least)
            .collect()
    }
}

/// A shape that several targets share.
struct Shared {
    positions: Vec<DVec3>,
    /// The normals of vertices that have others than at rest.
    normals: Vec<(usize, DVec3)>,
    /// The positions that they move, or that are next to those.
    taken: Vec<bool>,
    /// The length of the largest delta.
    largest: f64,
}

/// The shapes with each morph target at weight 1. Targets that move no vertex in common, and none
/// next to each other, share a shape.
fn target_shapes(
    mesh: &Mesh,
    targets: &Targets<'_>,
    at_rest: &[DVec3],
    normals: &[DVec3],
    diagonal: f64,
) -> Vec<TargetShape> {
    let ids = mesh.position_ids();
    let vertices = mesh.vertex_count();
    let numbers: BTreeSet<u32> =
        targets.deltas.keys().chain(targets.normal_deltas.keys()).copied().collect();
    let mut all: Vec<Shared> = Vec::new();
    for target in numbers {
        let changed = |streams: &BTreeMap<u32, Vec<&Attribute>>, least: f64| {
            targets.changed(streams.get(&target), target, vertices, least)
        };
        let moved = changed(&targets.deltas, MIN_DELTA_SHARE * diagonal);
        let turned = changed(&targets.normal_deltas, MIN_NORMAL_DELTA);
        if moved.is_empty() && turned.is_empty() {
            continue;
        }
        let mut near = vec![false; ids.len()];
        let changed = moved.iter().chain(&turned);
        changed.for_each(|&(v, _)| near[ids.of_vertex[v] as usize] = true);
        let positions = |t: &[u32; 3]| t.map(|v| ids.of_vertex[v as usize] as usize);
        let touched: Vec<[usize; 3]> =
            mesh.triangles().iter().map(positions).filter(|t| t.iter().any(|&p| near[p])).collect();
        touched.iter().flatten().for_each(|&p| near[p] = true);
        let is_apart = |shape: &&mut Shared| {
            !shape.taken.iter().zip(&near).any(|(&taken, &near)| taken && near)
        };
        // No more shapes are asked than are kept, so that work is linear in the number of targets.
        let shared = match all.iter_mut().take(MAX_TARGET_SHAPES).find(is_apart) {
            Some(shared) => shared,
            None => {
                let (positions, taken) = (at_rest.to_vec(), vec![false; ids.len()]);
                all.push(Shared { positions, normals: Vec::new(), taken, largest: 0.0 });
                all.last_mut().expect("just pushed")
            }
        };
        shared.taken.iter_mut().zip(&near).for_each(|(taken, near)| *taken |= near);
        for (v, delta) in moved {
            shared.positions[v] += delta;
            shared.largest = shared.largest.max(delta.length());
        }
        let normal =
            |(v, delta): (usize, DVec3)| (v, (normals[v] + delta).normalize_or(normals[v]));
        shared.normals.extend(turned.into_iter().map(normal));
    }
    all.sort_by(|a, b| b.largest.total_cmp(&a.largest));
    all.truncate(MAX_TARGET_SHAPES);
    let shape = |shared: Shared| {
        let positions = shared.positions.into_iter().map(to_single).collect();
        let mut all = Vec::new();
        if !shared.normals.is_empty() {
            all.extend(normals.iter().map(|n| to_single(*n)));
            shared.normals.into_iter().for_each(|(v, normal)| all[v] = to_single(normal));
        }
        TargetShape { positions, normals: all }
    };
    all.into_iter().map(shape).collect()
}
