//! Chooses the poses of an object that matter for its errors: those in which its shape differs most
//! from rest and from each other.
//!
//! Shapes are compared by distances between pairs of vertices, which a motion of the whole object
//! does not change. The pose that is farthest from all chosen ones is the next (Gonzalez 1985).

use super::{Moment, Motion};
use crate::placement::Placement;
use crate::posed::{Streams, placed, posed_vertex, vector};
use crate::scale::representative;
use crate::transform::Transform;
use glam::DVec3;
use lodc_mesh::{Attribute, Mesh, Posture, Semantic};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Moments of a second of an animation that are tried. Chosen by hand, as are the next three.
const MOMENTS_PER_SECOND: f64 = 16.0;
/// Fewest moments of an animation that are tried.
const MIN_MOMENTS: usize = 4;
/// Most moments of all animations together that are tried.
const MAX_MOMENTS: usize = 128;
/// Most vertices whose distances are compared.
const MAX_VERTICES: usize = 1024;

/// Shapes whose distances differ by less than this share of the largest are nearly the same. Chosen
/// by hand.
const NEARLY_SAME: f64 = 0.01;

/// A pose that may be chosen, with the distances of an object in it.
type Candidate = (Posture, Vec<f64>);

impl Motion {
    /// Chooses for each object up to `most` poses in which its shape differs most from the one at
    /// rest and from those before: moments of animations, and morph targets at weight 1. The list
    /// of an object is empty if it has neither skin nor morph targets, or only moves as a whole.
    #[must_use]
    pub fn choose(&self, meshes: &[&Mesh], most: usize) -> Vec<Vec<Posture>> {
        let objects = meshes.iter().enumerate();
        let deformable: Vec<Option<Deformable>> =
            objects.map(|(o, m)| self.deformable(o, m)).collect();
        if most == 0 || deformable.iter().all(Option::is_none) {
            return vec![Vec::new(); meshes.len()];
        }
        let moments = self.moments();
        let choose = |object: &Option<Deformable>| {
            let Some(object) = object else { return Vec::new() };
            farthest(object, self.candidates(object, &moments), most)
        };
        deformable.par_iter().map(choose).collect()
    }

    /// Returns an object if its shape may change.
    fn deformable<'a>(&'a self, object: usize, mesh: &'a Mesh) -> Option<Deformable<'a>> {
        let (Some(rest), scale) = representative(mesh, object, &self.rest) else { return None };
        let targets = targets(mesh);
        let deforms = !rest.joints.is_empty() || !targets.is_empty();
        deforms.then_some(Deformable { mesh, rest, scale, targets })
    }

    /// Moments of all animations, evenly spread over each.
    fn moments(&self) -> Vec<(Posture, Moment)> {
        let animations = self.animations.len();
        let share = (MAX_MOMENTS / animations.max(1)).max(MIN_MOMENTS);
        let times = |(number, animation): (usize, &crate::Animation)| {
            let length = animation.duration();
            let count = ((length * MOMENTS_PER_SECOND) as usize + 1).clamp(MIN_MOMENTS, share);
            let seconds = move |i: usize| length * i as f64 / (count - 1) as f64;
            (0..count).map(move |i| (number, seconds(i))).collect::<Vec<_>>()
        };
        let all: Vec<_> = self.animations.iter().enumerate().flat_map(times).collect();
        let moment = |&(number, seconds): &(usize, f64)| {
            let posture = Posture::Moment { animation: number as u32, seconds };
            (posture, self.moment(&self.animations[number], seconds))
        };
        let every = all.len().div_ceil(MAX_MOMENTS).max(1);
        all.par_iter().step_by(every).map(moment).collect()
    }

    /// The poses that an object may take.
    fn candidates(&self, object: &Deformable, moments: &[(Posture, Moment)]) -> Vec<Candidate> {
        let at = |(posture, moment): &(Posture, Moment)| {
            (*posture, object.distances(&moment.placed(&self.graph, object.rest)))
        };
        let rest = AtRest::new(object);
        let with = |(&target, deltas): (&u32, &Deltas<'_>)| {
            (Posture::Target(target), rest.distances(target, deltas))
        };
        moments.par_iter().map(at).chain(object.targets.par_iter().map(with)).collect()
    }
}

/// An object whose shape may change.
struct Deformable<'a> {
    mesh: &'a Mesh,
    rest: &'a Placement,
    /// Its scale at rest.
    scale: f64,
    /// Its morph targets.
    targets: BTreeMap<u32, Deltas<'a>>,
}

/// The deltas of positions of one morph target: a submesh, rising, and those of its vertices.
type Deltas<'a> = Vec<(usize, &'a Attribute)>;

/// Returns the morph targets that move positions of a mesh.
fn targets(mesh: &Mesh) -> BTreeMap<u32, Deltas<'_>> {
    let mut targets: BTreeMap<u32, Deltas<'_>> = BTreeMap::new();
    for (s, submesh) in mesh.submeshes().iter().enumerate() {
        for attribute in submesh.attributes.iter().map(|&a| &mesh.attributes()[a as usize]) {
            if let (Some(target), Semantic::Position) =
                (attribute.morph_target, &attribute.semantic)
            {
                targets.entry(target).or_default().push((s, attribute));
            }
        }
    }
    targets
}

impl Deformable<'_> {
    /// Vertices whose distances are compared.
    fn sample(&self) -> impl Iterator<Item = u32> {
        let vertices = self.mesh.vertex_count();
        let every = vertices.div_ceil(MAX_VERTICES).max(1);
        (0..vertices).step_by(every).map(|v| v as u32)
    }

    /// Distances between pairs of vertices in a placement, in mesh units. Each of a sample of
    /// vertices is paired with the one half the sample further on: vertices near each other in the
    /// file are near in space, and distances across the object change most when it bends.
    fn distances(&self, placement: &Placement) -> Vec<f64> {
        let streams = Streams::of(self.mesh, placement);
        let positions = self.sample().map(|v| posed_vertex(&streams, self.mesh, placement, v).0);
        self.pair_distances(&positions.collect::<Vec<_>>())
    }

    /// Distances between pairs of the sample, from its positions.
    fn pair_distances(&self, positions: &[DVec3]) -> Vec<f64> {
        let half = positions.len() / 2;
        let distance = |i: usize| {
            (positions[i] - positions[(i + half) % positions.len()]).length() / self.scale
        };
        (0..positions.len()).map(distance).collect()
    }
}

/// The sample of an object at rest. Morph targets are many where each is looked at by itself, so
/// one takes time for its own deltas alone.
struct AtRest<'a> {
    object: &'a Deformable<'a>,
    /// Of each vertex its position before joints and nodes, and their transform of it.
    sample: Vec<(u32, DVec3, Transform)>,
}

impl<'a> AtRest<'a> {
    fn new(object: &'a Deformable<'a>) -> Self {
        let (mesh, rest) = (object.mesh, object.rest);
        let streams = Streams::of(mesh, rest);
        let known = |v: u32| (v, streams.position(mesh, v), streams.transform(mesh, rest, v));
        Self { object, sample: object.sample().map(known).collect() }
    }

    /// Distances with a morph target at weight 1.
    fn distances(&self, target: u32, deltas: &Deltas<'_>) -> Vec<f64> {
        let weight = self.object.rest.weights.get(target as usize).copied().unwrap_or(0.0);
        let submeshes = self.object.mesh.vertex_submesh();
        let moved = |&(v, position, transform): &(u32, DVec3, Transform)| {
            let submesh = submeshes[v as usize] as usize;
            let first = deltas.partition_point(|(s, _)| *s < submesh);
            let own = deltas[first..].iter().take_while(|(s, _)| *s == submesh);
            let sum = own.fold(position, |sum, (_, delta)| sum + (1.0 - weight) * vector(delta, v));
            placed(&transform, sum)
        };
        self.object.pair_distances(&self.sample.iter().map(moved).collect::<Vec<_>>())
    }
}

/// Chooses up to `most` of some poses, the farthest first.
fn farthest(object: &Deformable, candidates: Vec<Candidate>, most: usize) -> Vec<Posture> {
    // Poses with positions that are not finite, or overflow as floats, are left out.
    let is_finite = |distances: &Vec<f64>| distances.iter().all(|&d| d < f64::from(f32::MAX));
    let (candidates, distances): (Vec<Posture>, Vec<Vec<f64>>) =
        candidates.into_iter().filter(|(_, distances)| is_finite(distances)).unzip();
    let mut latest = object.distances(object.rest);
    let min_difference = NEARLY_SAME * latest.iter().copied().fold(0.0, f64::max);
    let mut distances_to_chosen = vec![f64::INFINITY; candidates.len()];
    let mut chosen = Vec::new();
    while chosen.len() < most {
        for (distances_to_chosen, distances_of) in distances_to_chosen.iter_mut().zip(&distances) {
            *distances_to_chosen = distances_to_chosen.min(difference(&latest, distances_of));
        }
        // Of equal ones the first.
        let next = (0..distances_to_chosen.len())
            .rev()
            .max_by(|&a, &b| distances_to_chosen[a].total_cmp(&distances_to_chosen[b]));
        let Some(next) = next.filter(|&next| distances_to_chosen[next] > min_difference) else {
            break;
        };
        latest.clone_from(&distances[next]);
        chosen.push(candidates[next]);
    }
    chosen
}

/// The largest difference between two lists of distances.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
