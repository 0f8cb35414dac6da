//! Chooses the poses of an object that matter for its errors: those in which its shape differs most
//! from rest and from each other.
//!
//! Shapes are compared by distances between pairs of vertices, which a motion of the whole object
//! does not change. The next pose is always the one that is farthest from all that are chosen
//! (Gonzalez 1985).

use super::movers::Mover;
use super::{Moment, Motion};
use crate::placement::Placement;
use crate::posed::{Streams, posed_vertex, transformed, vector};
use crate::transform::Transform;
use glam::DVec3;
use lodc_mesh::{Attribute, Mesh, PoseKey, Semantic};
use rayon::prelude::*;
use std::collections::BTreeMap;

// Limits of the search, chosen by hand: more find poses that differ slightly more, in more time.

/// Moments that are tried for each second of an animation.
const MOMENTS_PER_SECOND: f64 = 16.0;
/// Fewest moments that are tried of one animation.
const MIN_MOMENTS: usize = 4;
/// Most moments that are tried of all animations together.
const MAX_MOMENTS: usize = 128;
/// Most vertices of an object whose distances are compared.
const MAX_VERTICES: usize = 1024;

/// A pose is not worth choosing if no distance differs by more than this share of the largest
/// distance at rest. Chosen by hand.
const MIN_DIFFERENCE_SHARE: f64 = 0.01;

/// A pose that may be chosen.
struct Candidate {
    pose_key: PoseKey,
    /// Distances between pairs of vertices of the object in that pose, in mesh units.
    distances: Vec<f64>,
}

impl Motion {
    /// Chooses for each object up to `max_poses` poses in which its shape differs most from the one
    /// at rest and from those chosen before: moments of animations, and morph targets at weight 1.
    /// The list of an object is empty if it has neither skin nor morph targets, or only moves as a
    /// whole.
    #[must_use]
    pub fn choose(&self, meshes: &[&Mesh], max_poses: usize) -> Vec<Vec<PoseKey>> {
        let objects = meshes.iter().enumerate();
        let deformable: Vec<Option<Deformable>> =
            objects.map(|(o, m)| self.deformable(o, m)).collect();
        if max_poses == 0 || deformable.iter().all(Option::is_none) {
            return vec![Vec::new(); meshes.len()];
        }
        let moments = self.moments();
        let choose = |object: &Option<Deformable>| {
            let Some(object) = object else { return Vec::new() };
            choose_farthest(object, self.candidates(object, &moments), max_poses)
        };
        deformable.par_iter().map(choose).collect()
    }

    /// Returns an object if its shape may change.
    fn deformable<'a>(&'a self, object: usize, mesh: &'a Mesh) -> Option<Deformable<'a>> {
        let targets = morph_targets(mesh);
        let has_joints = self.rest.of(object).any(|placement| !placement.joints.is_empty());
        if !has_joints && targets.is_empty() {
            return None;
        }
        let measured = self.measured_placements(mesh, object);
        let movers = self.movers(object, &measured);
        let rest = movers.first()?.placement.clone();
        Some(Deformable { mesh, movers, rest, scale: measured.scale, targets })
    }

    /// Returns moments of all animations, evenly spread over each.
    fn moments(&self) -> Vec<(PoseKey, Moment)> {
        let animations = self.animations.len();
        let max_of_one = (MAX_MOMENTS / animations.max(1)).max(MIN_MOMENTS);
        let times = |(number, animation): (usize, &crate::Animation)| {
            let duration = animation.duration();
            let count =
                ((duration * MOMENTS_PER_SECOND) as usize + 1).clamp(MIN_MOMENTS, max_of_one);
            let seconds = move |i: usize| duration * i as f64 / (count - 1) as f64;
            (0..count).map(move |i| (number, seconds(i))).collect::<Vec<_>>()
        };
        let all: Vec<_> = self.animations.iter().enumerate().flat_map(times).collect();
        let moment = |&(number, seconds): &(usize, f64)| {
            let pose_key = PoseKey::Moment { animation: number as u32, seconds };
            (pose_key, self.moment(&self.animations[number], seconds))
        };
        let stride = all.len().div_ceil(MAX_MOMENTS).max(1);
        all.par_iter().step_by(stride).map(moment).collect()
    }

    /// Returns the poses that an object may take.
    fn candidates(&self, object: &Deformable, moments: &[(PoseKey, Moment)]) -> Vec<Candidate> {
        let at_moment = |(pose_key, moment): &(PoseKey, Moment)| {
            let placed = moment.all_placed(&self.graph, &object.movers);
            let candidate = |mover: Mover| Candidate {
                pose_key: *pose_key,
                distances: object.distances(&mover.placement),
            };
            placed.into_iter().map(candidate).collect::<Vec<_>>()
        };
        let rest = AtRest::new(object);
        let with_target = |(&target, deltas): (&u32, &Deltas<'_>)| Candidate {
            pose_key: PoseKey::Target(target),
            distances: rest.distances(target, deltas),
        };
        let targets = object.targets.par_iter().map(with_target);
        moments.par_iter().flat_map_iter(at_moment).chain(targets).collect()
    }
}

/// An object whose shape may change.
struct Deformable<'a> {
    mesh: &'a Mesh,
    /// Its placements that pose keys change.
    movers: Vec<Mover>,
    /// The first of them, at rest.
    rest: Placement,
    /// World units per mesh unit.
    scale: f64,
    /// Its morph targets that move positions, by number.
    targets: BTreeMap<u32, Deltas<'a>>,
}

/// The deltas of positions of one morph target: pairs of a submesh and the stream of its vertices'
/// deltas, by rising submesh.
type Deltas<'a> = Vec<(usize, &'a Attribute)>;

/// Returns the morph targets that move positions of a mesh, by number.
fn morph_targets(mesh: &Mesh) -> BTreeMap<u32, Deltas<'_>> {
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
    /// Iterates over the vertices whose distances are compared.
    fn sample(&self) -> impl Iterator<Item = u32> {
        let vertices = self.mesh.vertex_count();
        let stride = vertices.div_ceil(MAX_VERTICES).max(1);
        (0..vertices).step_by(stride).map(|v| v as u32)
    }

    /// Returns distances between pairs of vertices in a placement, in mesh units. Each vertex of
    /// the sample is paired with the one half the sample further on. Vertices close to each other
    /// in the file are mostly close in space, so these pairs are far apart, and the distances
    /// between them change most when the object bends.
    fn distances(&self, placement: &Placement) -> Vec<f64> {
        let streams = Streams::of(self.mesh, placement);
        let positions = self.sample().map(|v| posed_vertex(&streams, self.mesh, placement, v).0);
        self.pair_distances(&positions.collect::<Vec<_>>())
    }

    /// Returns the same distances, given the positions of the sample.
    fn pair_distances(&self, positions: &[DVec3]) -> Vec<f64> {
        let half = positions.len() / 2;
        let distance = |i: usize| {
            (positions[i] - positions[(i + half) % positions.len()]).length() / self.scale
        };
        (0..positions.len()).map(distance).collect()
    }
}

/// The sample of an object at rest. It is computed once, since an object may have many morph
/// targets: for each target only its deltas are added.
struct AtRest<'a> {
    object: &'a Deformable<'a>,
    sample: Vec<SampleVertex>,
}

/// A vertex of the sample at rest.
struct SampleVertex {
    vertex: u32,
    /// Its position before joints and its node move it.
    position: DVec3,
    /// The transform that its joints or its node apply.
    transform: Transform,
}

impl<'a> AtRest<'a> {
    fn new(object: &'a Deformable<'a>) -> Self {
        let (mesh, rest) = (object.mesh, &object.rest);
        let streams = Streams::of(mesh, rest);
        let at_rest = |vertex: u32| SampleVertex {
            vertex,
            position: streams.position(mesh, vertex),
            transform: streams.transform(mesh, rest, vertex),
        };
        Self { object, sample: object.sample().map(at_rest).collect() }
    }

    /// Returns the distances with a morph target at weight 1.
    fn distances(&self, target: u32, deltas: &Deltas<'_>) -> Vec<f64> {
        let weight = self.object.rest.weights.get(target as usize).copied().unwrap_or(0.0);
        let submeshes = self.object.mesh.vertex_submesh();
        let moved = |at_rest: &SampleVertex| {
            let v = at_rest.vertex;
            let submesh = submeshes[v as usize] as usize;
            let first = deltas.partition_point(|(s, _)| *s < submesh);
            let of_submesh = deltas[first..].iter().take_while(|(s, _)| *s == submesh);
            // At rest the target already has `weight`.
            let add = |sum: DVec3, (_, delta): &(usize, &Attribute)| {
                sum + (1.0 - weight) * vector(delta, v)
            };
            transformed(&at_rest.transform, of_submesh.fold(at_rest.position, add))
        };
        self.object.pair_distances(&self.sample.iter().map(moved).collect::<Vec<_>>())
    }
}

/// Chooses up to `max_poses` of some poses, the farthest from rest first.
fn choose_farthest(
    object: &Deformable,
    candidates: Vec<Candidate>,
    max_poses: usize,
) -> Vec<PoseKey> {
    // Poses with positions that are not finite, or overflow as floats, are left out.
    let is_finite = |c: &Candidate| c.distances.iter().all(|&d| d < f64::from(f32::MAX));
    let candidates: Vec<Candidate> = candidates.into_iter().filter(is_finite).collect();
    // The distances of the pose chosen last, in each placement that it moves; at first those at
    // rest.
    let mut latest: Vec<Vec<f64>> =
        object.movers.iter().map(|mover| object.distances(&mover.placement)).collect();
    let negligible = MIN_DIFFERENCE_SHARE * latest[0].iter().copied().fold(0.0, f64::max);
    // For each candidate its difference from the most similar one of rest and the chosen poses.
    let mut min_differences = vec![f64::INFINITY; candidates.len()];
    let mut chosen = Vec::new();
    while chosen.len() < max_poses {
        for (min_difference, candidate) in min_differences.iter_mut().zip(&candidates) {
            for latest in &latest {
                let difference = largest_difference(latest, &candidate.distances);
                *min_difference = min_difference.min(difference);
            }
        }
        // The largest; the first of equals.
        let next = (0..candidates.len())
            .rev()
            .max_by(|&a, &b| min_differences[a].total_cmp(&min_differences[b]));
        let Some(next) = next.filter(|&next| min_differences[next] > negligible) else {
            break;
        };
        let pose_key = candidates[next].pose_key;
        let shown = candidates.iter().filter(|candidate| candidate.pose_key == pose_key);
        latest = shown.map(|candidate| candidate.distances.clone()).collect();
        chosen.push(pose_key);
    }
    chosen
}

/// Returns the largest difference between two lists of distances.
fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
