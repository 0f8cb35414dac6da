//! What moves vertices: the deltas of morph targets, joints and their weights. Vertices that are at
//! one position at rest may part in motion, such as lips that touch, or a face and what lies on it.

use crate::{Attribute, Semantic, Submesh};
use std::collections::BTreeMap;

/// Vertices whose joints have weights that differ by no more than this are welded. Chosen by hand:
/// the steps of weights stored in eight bits are 0.004.
const MAX_WEIGHT_DIFFERENCE: f32 = 0.01;

/// The streams of a mesh by which its vertices move.
pub(crate) struct MotionStreams<'a> {
    /// The deltas of positions, by morph target. A vertex has zeros in those of other submeshes.
    deltas: BTreeMap<u32, Vec<&'a Attribute>>,
    /// The streams of joints' indices and those of their weights, by set.
    joints: BTreeMap<u32, [Vec<&'a Attribute>; 2]>,
    /// The submesh of each vertex.
    vertex_submesh: &'a [u32],
    /// For each submesh the first one that stores its motion in the same streams.
    formats: Vec<u32>,
}

impl<'a> MotionStreams<'a> {
    /// Finds the streams of a mesh.
    pub(crate) fn of(
        attributes: &'a [Attribute],
        submeshes: &[Submesh],
        vertex_submesh: &'a [u32],
    ) -> Self {
        let is_moving = |&a: &u32| attributes.get(a as usize).is_some_and(Attribute::moves);
        let mut firsts = BTreeMap::new();
        let format = |(submesh, number): (&Submesh, u32)| {
            let mut streams: Vec<u32> =
                submesh.attributes.iter().copied().filter(is_moving).collect();
            streams.sort_unstable();
            *firsts.entry(streams).or_insert(number)
        };
        let formats = submeshes.iter().zip(0..).map(format).collect();
        let (deltas, joints) = (BTreeMap::new(), BTreeMap::new());
        let mut found = Self { deltas, joints, vertex_submesh, formats };
        for a in attributes {
            match (&a.semantic, a.morph_target) {
                (Semantic::Position, Some(target)) => {
                    found.deltas.entry(target).or_default().push(a);
                }
                (Semantic::Joints(set), None) => found.joints.entry(*set).or_default()[0].push(a),
                (Semantic::Weights(set), None) => found.joints.entry(*set).or_default()[1].push(a),
                _ => {}
            }
        }
        found
    }

    /// The number of the streams that a vertex's motion is stored in.
    fn format(&self, vertex: u32) -> u32 {
        self.formats.get(self.vertex_submesh[vertex as usize] as usize).copied().unwrap_or(0)
    }

    /// Returns whether nothing moves a vertex by itself.
    pub(crate) fn is_empty(&self) -> bool {
        self.deltas.is_empty() && self.joints.is_empty()
    }

    /// Returns whether two vertices move alike: those at one position at rest stay at one then.
    pub(crate) fn move_alike(&self, a: u32, b: u32) -> bool {
        let key = |v: u32| {
            let mut words = Vec::new();
            self.put_key(v, &mut words);
            words
        };
        a == b || self.is_empty() || key(a) == key(b)
    }

    /// Returns whether two vertices move alike up to a tolerance: no morph target moves one of them
    /// by a vector that is farther from the other's, and no joint has a weight that differs by more
    /// than [`MAX_WEIGHT_DIFFERENCE`].
    pub(crate) fn move_nearly_alike(&self, a: u32, b: u32, tolerance: f64) -> bool {
        if self.is_empty() {
            return true;
        }
        let near = |streams: &Vec<&Attribute>| {
            let difference =
                |i: usize| f64::from(sum_of(streams, a, i)) - f64::from(sum_of(streams, b, i));
            (0..3).map(|i| difference(i).powi(2)).sum::<f64>() <= tolerance * tolerance
        };
        let (of_a, of_b) = (self.joints_of(a), self.joints_of(b));
        let weight = |joints: &[(u32, f32)], joint: u32| -> f32 {
            joints.iter().filter(|(j, _)| *j == joint).map(|(_, w)| w).sum()
        };
        self.format(a) == self.format(b)
            && self.deltas.values().all(near)
            && of_a.iter().chain(&of_b).all(|&(joint, _)| {
                (weight(&of_a, joint) - weight(&of_b, joint)).abs() <= MAX_WEIGHT_DIFFERENCE
            })
    }

    /// Appends the key of a vertex's motion, which is equal for vertices that move alike. Deltas
    /// and weights of 0 are left out, and joints are in the order of their numbers. Vertices whose
    /// submeshes store motion in different streams never move alike: none can take over another's.
    pub(crate) fn put_key(&self, vertex: u32, key: &mut Vec<u32>) {
        key.push(self.format(vertex));
        for (&target, streams) in &self.deltas {
            let delta: [f32; 3] = std::array::from_fn(|i| sum_of(streams, vertex, i));
            if delta != [0.0; 3] {
                key.push(target);
                key.extend(delta.map(|x| (x + 0.0).to_bits()));
            }
        }
        key.push(u32::MAX);
        let joints = self.joints_of(vertex);
        key.extend(joints.iter().flat_map(|&(joint, weight)| [joint, weight.to_bits()]));
    }

    /// The joints of a vertex with their weights, which are not 0, in order.
    fn joints_of(&self, vertex: u32) -> Vec<(u32, f32)> {
        let mut joints: Vec<(u32, f32)> = Vec::new();
        for [indices, weights] in self.joints.values() {
            let components = |streams: &[&Attribute]| {
                streams.iter().map(|a| usize::from(a.components)).max().unwrap_or(0)
            };
            for i in 0..components(indices).min(components(weights)) {
                let weight = sum_of(weights, vertex, i);
                if weight != 0.0 {
                    joints.push((sum_of(indices, vertex, i) as u32, weight));
                }
            }
        }
        joints.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        joints
    }
}

/// A component of a vertex: the sum over all streams, as it has zeros in those of other submeshes.
fn sum_of(streams: &[&Attribute], vertex: u32, component: usize) -> f32 {
    let has = |a: &&&Attribute| component < usize::from(a.components);
    streams.iter().filter(has).map(|a| a.value(vertex, component)).sum()
}
