//! Interpolates joints and weights between the corners of a triangle: influences of one joint are
//! summed, the strongest kept.

use crate::blend::{Source, store};
use lodc_mesh::{Attribute, Component, Mesh, MeshParts, Semantic};

/// The streams of one set of influences, as indices of attributes.
struct InfluenceSet {
    joints: usize,
    weights: usize,
}

/// How much a joint moves a vertex.
#[derive(Clone, Copy)]
struct Influence {
    joint: u32,
    weight: f64,
}

/// Returns the sets of a mesh's influences in order.
fn influence_sets(attributes: &[Attribute]) -> Vec<InfluenceSet> {
    let find = |wanted: &Semantic| {
        attributes.iter().position(|a| a.semantic == *wanted && a.morph_target.is_none())
    };
    let mut sets = Vec::new();
    for set in 0.. {
        match (find(&Semantic::Joints(set)), find(&Semantic::Weights(set))) {
            (Some(joints), Some(weights)) => sets.push(InfluenceSet { joints, weights }),
            _ => break,
        }
    }
    sets
}

/// Replaces the influences of each vertex that has a source by the source's: those of its corners,
/// added up by joint, the strongest that there is room for, scaled to sum up to 1.
pub(crate) fn blend(parts: &mut MeshParts, input: &Mesh, sources: &[Option<Source>]) {
    let sets = influence_sets(input.attributes());
    if sets.is_empty() {
        return;
    }
    let capacity: usize =
        sets.iter().map(|s| usize::from(input.attributes()[s.joints].components)).sum();
    for (v, source) in sources.iter().enumerate() {
        let Some(source) = source else { continue };
        let mut influences = summed_influences(input, &sets, source);
        influences.truncate(capacity);
        let sum: f64 = influences.iter().map(|i| i.weight).sum();
        if sum <= 0.0 {
            continue;
        }
        influences.iter_mut().for_each(|i| i.weight /= sum);
        influences.resize(capacity, Influence { joint: 0, weight: 0.0 });
        round_weights(&mut influences, &input.attributes()[sets[0].weights]);
        let mut remaining = &influences[..];
        for set in &sets {
            let in_set;
            let count = usize::from(parts.attributes[set.joints].components);
            (in_set, remaining) = remaining.split_at(count);
            let joints: Vec<f64> = in_set.iter().map(|i| f64::from(i.joint)).collect();
            let weights: Vec<f64> = in_set.iter().map(|i| i.weight).collect();
            store(&mut parts.attributes[set.joints], v, &joints);
            store(&mut parts.attributes[set.weights], v, &weights);
        }
    }
}

/// Returns the influences at a point of the input, each joint once, the strongest first, of equal
/// ones the lower joint.
fn summed_influences(input: &Mesh, sets: &[InfluenceSet], source: &Source) -> Vec<Influence> {
    let mut influences: Vec<Influence> = Vec::new();
    for (&vertex, share) in source.vertices.iter().zip(&source.weights) {
        for set in sets {
            let joints = &input.attributes()[set.joints];
            let weights = &input.attributes()[set.weights];
            for k in 0..usize::from(joints.components.min(weights.components)) {
                let weight = f64::from(weights.value(vertex, k)) * share;
                let joint = joints.value(vertex, k) as u32;
                match influences.iter_mut().find(|i| i.joint == joint) {
                    _ if weight <= 0.0 => {}
                    Some(influence) => influence.weight += weight,
                    None => influences.push(Influence { joint, weight }),
                }
            }
        }
    }
    influences.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.joint.cmp(&b.joint)));
    influences
}

/// Rounds weights to what an integer stream can hold such that they still sum up to 1: what is
/// left over goes to the strongest.
fn round_weights(influences: &mut [Influence], weights: &Attribute) {
    let max_value = match weights.component {
        Component::U8 if weights.normalized => 255.0,
        Component::U16 if weights.normalized => 65535.0,
        _ => return,
    };
    influences.iter_mut().for_each(|i| i.weight = (i.weight * max_value).round() / max_value);
    let sum: f64 = influences.iter().map(|i| i.weight).sum();
    influences[0].weight += 1.0 - sum;
}
