//! The shapes of an object that simplification looks at: at rest, with each of its morph targets,
//! and in poses.

use super::{Motion, ObjectShapes};
use crate::placement::Placement;
use crate::posed::{Streams, vector};
use glam::{DVec3, Vec3};
use lodc_mesh::{Attribute, Mesh, Posture, Semantic, SplitMix64};
use std::collections::BTreeMap;

/// The most shapes with morph targets that are looked at. Where more targets move the same places,
/// those of the largest deltas count. Chosen by hand.
pub const MAX_TARGET_SHAPES: usize = 96;
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
    /// With morph targets at weight 1, each by itself; targets that move places apart from each
    /// other share a shape.
    pub targets: Vec<Vec<[f32; 3]>>,
    /// In placements that give it another shape.
    pub placements: Vec<Vec<[f32; 3]>>,
    /// In poses of animations.
    pub poses: Vec<Vec<[f32; 3]>>,
}

impl Motion {
    /// Returns the shapes of an object in which collapses are priced: those at rest, of every morph
    /// target, and in those of `postures` that are moments of animations. None if neither joints
    /// nor morph targets move it.
    #[must_use]
    pub fn seen(&self, mesh: &Mesh, object: usize, postures: &[Posture]) -> Option<SeenPositions> {
        let deltas = deltas(mesh);
        let is_skinned = self.rest.of(object).any(|placement| !placement.joints.is_empty());
        if deltas.is_empty() && !is_skinned {
            return None;
        }
        let is_moment = |p: &&Posture| matches!(p, Posture::Moment { .. });
        let moments: Vec<Posture> = postures.iter().filter(is_moment).copied().collect();
        let shapes = self.shapes(mesh, object, &moments);
        let first = self.measured_placements(mesh, object).placements.into_iter().next();
        let weights = first.map_or_else(Vec::new, |at| at.placement.weights.to_vec());
        let mut seen = SeenPositions::default();
        let at_rest = at_rest(mesh, &weights);
        let diagonal = diagonal(&at_rest);
        let others = other_shapes(mesh, &shapes, &at_rest, diagonal);
        [seen.placements, seen.poses] = others;
        seen.targets = target_shapes(mesh, &deltas, &weights, &at_rest, diagonal);
        if at_rest.iter().zip(mesh.positions()).any(|(p, raw)| to_single(*p) != *raw) {
            seen.at_rest = at_rest.into_iter().map(to_single).collect();
        }
        Some(seen)
    }
}

fn to_single(p: DVec3) -> [f32; 3] {
    p.as_vec3().to_array()
}

/// The deltas of positions of each morph target that moves vertices.
fn deltas(mesh: &Mesh) -> BTreeMap<u32, Vec<&Attribute>> {
    let mut deltas: BTreeMap<u32, Vec<&Attribute>> = BTreeMap::new();
    for a in mesh.attributes().iter().filter(|a| a.semantic == Semantic::Position) {
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

fn diagonal(positions: &[DVec3]) -> f64 {
    let (low, high) = positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    if positions.is_empty() { 0.0 } else { (high - low).length() }
}

/// The shapes of placements, and those of postures, that are others than that at rest, and than
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
    for (shape, kind) in placements.chain(shapes.of_postures().iter().map(|shape| (shape, 1))) {
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

/// A shape that several targets share.
struct Shared {
    positions: Vec<DVec3>,
    /// The positions that they move, or that are next to those.
    taken: Vec<bool>,
    /// The length of the largest delta.
    largest: f64,
}

/// The shapes with each morph target at weight 1. Targets that move no vertex in common, and none
/// next to each other, share a shape.
fn target_shapes(
    mesh: &Mesh,
    deltas: &BTreeMap<u32, Vec<&Attribute>>,
    weights: &[f64],
    at_rest: &[DVec3],
    diagonal: f64,
) -> Vec<Vec<[f32; 3]>> {
    let ids = mesh.position_ids();
    let least = MIN_DELTA_SHARE * diagonal;
    let mut all: Vec<Shared> = Vec::new();
    for (&target, streams) in deltas {
        let weight = 1.0 - weights.get(target as usize).copied().unwrap_or(0.0);
        let moved: Vec<(usize, DVec3)> = (0..mesh.vertex_count())
            .map(|v| {
                let delta = streams.iter().map(|a| vector(a, v as u32)).sum::<DVec3>();
                (v, weight * delta)
            })
            .filter(|(_, delta)| delta.is_finite() && delta.length() > least)
            .collect();
        if moved.is_empty() {
            continue;
        }
        let mut near = vec![false; ids.len()];
        moved.iter().for_each(|&(v, _)| near[ids.of_vertex[v] as usize] = true);
        let positions = |t: &[u32; 3]| t.map(|v| ids.of_vertex[v as usize] as usize);
        let touched: Vec<[usize; 3]> =
            mesh.triangles().iter().map(positions).filter(|t| t.iter().any(|&p| near[p])).collect();
        touched.iter().flatten().for_each(|&p| near[p] = true);
        let is_apart = |shape: &&mut Shared| {
            !shape.taken.iter().zip(&near).any(|(&taken, &near)| taken && near)
        };
        let shared = match all.iter_mut().find(is_apart) {
            Some(shared) => shared,
            None => {
                let taken = vec![false; ids.len()];
                all.push(Shared { positions: at_rest.to_vec(), taken, largest: 0.0 });
                all.last_mut().expect("just pushed")
            }
        };
        shared.taken.iter_mut().zip(&near).for_each(|(taken, near)| *taken |= near);
        for (v, delta) in moved {
            shared.positions[v] += delta;
            shared.largest = shared.largest.max(delta.length());
        }
    }
    all.sort_by(|a, b| b.largest.total_cmp(&a.largest));
    all.truncate(MAX_TARGET_SHAPES);
    all.into_iter().map(|shape| shape.positions.into_iter().map(to_single).collect()).collect()
}
