//! Interpolates joints and weights between the corners of a triangle: influences of one joint are
//! summed, the strongest kept.

use crate::blend::{Source, put};
use lodc_mesh::{Attribute, Component, Mesh, MeshParts, Semantic};

/// The streams of one skin in a mesh: (joints, weights) by set.
fn sets(attributes: &[Attribute]) -> Vec<(usize, usize)> {
    let find = |wanted: &Semantic| {
        attributes.iter().position(|a| a.semantic == *wanted && a.morph_target.is_none())
    };
    let mut sets = Vec::new();
    for set in 0.. {
        match (find(&Semantic::Joints(set)), find(&Semantic::Weights(set))) {
            (Some(joints), Some(weights)) => sets.push((joints, weights)),
            _ => break,
        }
    }
    sets
}

/// Replaces the influences of the vertices that have a source: those of its corners, added up by
/// joint, the strongest that there is room for, made to sum up to 1.
pub(crate) fn blend(parts: &mut MeshParts, input: &Mesh, sources: &[Source]) {
    let sets = sets(input.attributes());
    if sets.is_empty() {
        return;
    }
    let capacity: usize =
        sets.iter().map(|s| usize::from(input.attributes()[s.0].components)).sum();
    for (v, source) in sources.iter().enumerate() {
        let Some((corners, weights)) = source else { continue };
        let mut influences = summed_influences(input, &sets, corners, weights);
        influences.truncate(capacity);
        let sum: f64 = influences.iter().map(|i| i.1).sum();
        if sum <= 0.0 {
            continue;
        }
        influences.iter_mut().for_each(|i| i.1 /= sum);
        influences.resize(capacity, (0, 0.0));
        round(&mut influences, &input.attributes()[sets[0].1]);
        let mut pending = &influences[..];
        for &(joints, weights) in &sets {
            let (in_set, others) =
                pending.split_at(usize::from(parts.attributes[joints].components));
            pending = others;
            let numbers: Vec<f64> = in_set.iter().map(|i| f64::from(i.0)).collect();
            let shares: Vec<f64> = in_set.iter().map(|i| i.1).collect();
            put(&mut parts.attributes[joints], v, &numbers);
            put(&mut parts.attributes[weights], v, &shares);
        }
    }
}

/// All influences of some corners by joint, the strongest first, of equal ones the lower joint.
fn summed_influences(
    input: &Mesh,
    sets: &[(usize, usize)],
    corners: &[u32; 3],
    shares: &[f64; 3],
) -> Vec<(u32, f64)> {
    let mut influences: Vec<(u32, f64)> = Vec::new();
    for (&corner, share) in corners.iter().zip(shares) {
        for &(joints, weights) in sets {
            let (joints, weights) = (&input.attributes()[joints], &input.attributes()[weights]);
            for k in 0..usize::from(joints.components.min(weights.components)) {
                let weight = f64::from(weights.value(corner, k)) * share;
                let joint = joints.value(corner, k) as u32;
                match influences.iter_mut().find(|i| i.0 == joint) {
                    _ if weight <= 0.0 => {}
                    Some(influence) => influence.1 += weight,
                    None => influences.push((joint, weight)),
                }
            }
        }
    }
    influences.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    influences
}

/// Rounds weights to what an integer stream can hold such that they still sum up to 1: what is
/// left over goes to the strongest.
fn round(influences: &mut [(u32, f64)], weights: &Attribute) {
    let max_value = match weights.component {
        Component::U8 if weights.normalized => 255.0,
        Component::U16 if weights.normalized => 65535.0,
        _ => return,
    };
    influences.iter_mut().for_each(|i| i.1 = (i.1 * max_value).round() / max_value);
    let sum: f64 = influences.iter().map(|i| i.1).sum();
    influences[0].1 += 1.0 - sum;
}
