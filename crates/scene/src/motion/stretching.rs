//! Moments of animations at which nodes and joints stretch otherwise than at rest.

use crate::animation::{Animation, Interpolation, Property};
use crate::graph::Graph;
use crate::transform::{LocalTransform, Transform, largest_stretch};
use glam::DMat3;
use lodc_mesh::PoseKey;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Most moments that are tried of all animations together. Chosen by hand.
const MAX_MOMENTS: usize = 512;
/// Moments that are looked at together. Chosen by hand: bounds the memory.
const MOMENTS_AT_ONCE: usize = 16;
/// Most moments of one node that are kept. Chosen by hand: instances have all of them.
const MAX_KEPT: usize = 8;
/// A moment that stretches by no more than this times a kept one is not kept itself. Chosen by
/// hand.
const ALIKE: f64 = 1.01;
/// Stretches that differ by a smaller share are the same. Chosen by hand.
const MAX_ROUNDING: f64 = 1e-6;

/// Where animations stretch nodes and joints otherwise than at rest.
#[derive(Clone, Debug, Default)]
pub(super) struct Stretching {
    /// By node that shows objects, without a skin: linear parts that stand for those at rest and at
    /// all moments. Nodes that are stretched as at rest are not here.
    pub(super) nodes: BTreeMap<u32, Vec<Stretched>>,
    /// By skin and joint: the moment at which the joint stretches most, and by how much; none where
    /// no moment stretches it more than at rest.
    pub(super) joints: BTreeMap<u32, Vec<Option<(f64, PoseKey)>>>,
}

/// How a node is stretched, at rest or at a moment.
#[derive(Clone, Debug)]
pub(super) struct Stretched {
    /// None at rest.
    pub(super) moment: Option<PoseKey>,
    /// The linear part of its world transform.
    pub(super) linear: DMat3,
    /// Distances in it are multiplied by this to hold for other moments, too.
    pub(super) growth: f64,
}

impl Stretching {
    pub(super) fn new(graph: &Graph, animations: &[Animation]) -> Self {
        let affected = affected(graph, animations);
        if !affected.iter().any(|&is| is) {
            return Self::default();
        }
        let moments = moments(graph, animations);
        let rest = graph.world_transforms(&graph.rest_pose());
        let shows = |n: &usize| {
            let node = &graph.nodes[*n];
            affected[*n] && !node.objects.is_empty() && node.skin.is_none()
        };
        let nodes: Vec<usize> = (0..graph.nodes.len()).filter(shows).collect();
        let mut of_nodes: Vec<Vec<Stretched>> = nodes
            .iter()
            .map(|&n| vec![Stretched { moment: None, linear: rest[n].matrix3, growth: 1.0 }])
            .collect();
        let is_affected = |&s: &usize| {
            let joints = &graph.skins[s].joints;
            joints.iter().any(|&j| affected.get(j as usize).is_some_and(|&is| is))
        };
        let skins: Vec<usize> = (0..graph.skins.len()).filter(is_affected).collect();
        let mut of_skins: Vec<Vec<Option<(f64, PoseKey)>>> =
            skins.iter().map(|&s| vec![None; graph.skins[s].joints.len()]).collect();
        for some in moments.chunks(MOMENTS_AT_ONCE) {
            let world_at = |&(animation, seconds): &(usize, f64)| {
                let pose = animations[animation].pose(graph, seconds);
                (
                    PoseKey::Moment { animation: animation as u32, seconds },
                    graph.world_transforms(&pose),
                )
            };
            let worlds: Vec<(PoseKey, Vec<Transform>)> = some.par_iter().map(world_at).collect();
            nodes.par_iter().zip(&mut of_nodes).for_each(|(&n, kept)| {
                for (moment, world) in &worlds {
                    keep(kept, *moment, world[n].matrix3);
                }
            });
            skins.par_iter().zip(&mut of_skins).for_each(|(&s, largest)| {
                for (moment, world) in &worlds {
                    let matrices = graph.skins[s].matrices(world);
                    for (joint, largest) in matrices.iter().zip(largest.iter_mut()) {
                        let stretch = largest_stretch(&joint.matrix3);
                        let is_larger = largest.is_none_or(|(before, _)| stretch > before);
                        if stretch.is_finite() && is_larger {
                            *largest = Some((stretch, *moment));
                        }
                    }
                }
            });
        }
        let is_as_at_rest =
            |kept: &Vec<Stretched>| matches!(kept[..], [Stretched { moment: None, .. }]);
        let nodes = nodes.into_iter().map(|n| n as u32).zip(of_nodes);
        Self {
            nodes: nodes.filter(|(_, kept)| !is_as_at_rest(kept)).collect(),
            joints: skins.into_iter().map(|s| s as u32).zip(of_skins).collect(),
        }
    }
}

/// Adds a moment to those that are kept of a node, unless one of them stands for it; leaves out
/// those that it stands for. What stands for a linear part stands for it with any instance: the
/// map between both is the same.
fn keep(kept: &mut Vec<Stretched>, moment: PoseKey, linear: DMat3) {
    if !linear.is_finite() {
        return;
    }
    let factor = |from: &DMat3, to: &DMat3| {
        let map = *to * from.inverse();
        let factor = if map.is_finite() { largest_stretch(&map) } else { f64::INFINITY };
        // A matrix without an inverse stands for itself and for what vanishes.
        if factor.is_finite() || largest_stretch(to) > 0.0 { factor } else { 0.0 }
    };
    let stands_in = |one: &Stretched| factor(&one.linear, &linear) / one.growth;
    let least = kept
        .iter()
        .map(stands_in)
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, f64::INFINITY));
    if least.1 <= 1.0 + MAX_ROUNDING {
        return;
    }
    if least.1 <= ALIKE && kept[least.0].growth == 1.0
        || kept.len() >= MAX_KEPT && least.1.is_finite()
    {
        kept[least.0].growth *= least.1;
        return;
    }
    kept.retain(|one| factor(&linear, &one.linear) * one.growth > 1.0 + MAX_ROUNDING);
    kept.push(Stretched { moment: Some(moment), linear, growth: 1.0 });
}

/// By node whether an animation may stretch it otherwise than at rest: if it or a node above has an
/// animated scale, or an animated rotation below a node that stretches unevenly.
fn affected(graph: &Graph, animations: &[Animation]) -> Vec<bool> {
    let nodes = graph.nodes.len();
    let (mut scaled, mut turned) = (vec![false; nodes], vec![false; nodes]);
    for channel in animations.iter().flat_map(|a| &a.channels) {
        let of = match channel.property {
            Property::Scale => &mut scaled,
            Property::Rotation => &mut turned,
            Property::Translation | Property::Weights => continue,
        };
        if let Some(node) = of.get_mut(channel.node as usize) {
            *node = true;
        }
    }
    let (mut is_affected, mut is_uneven) = (vec![false; nodes], vec![false; nodes]);
    for visit in graph.walk(graph.topmost().into_iter()) {
        let above = |of: &[bool]| visit.parent.is_some_and(|parent| of[parent]);
        let n = visit.node;
        is_affected[n] = above(&is_affected) || scaled[n] || turned[n] && above(&is_uneven);
        is_uneven[n] = above(&is_uneven) || scaled[n] || stretches_unevenly(&graph.nodes[n].local);
    }
    is_affected
}

fn stretches_unevenly(local: &LocalTransform) -> bool {
    match local {
        LocalTransform::Trs { scale: [x, y, z], .. } => x.abs() != y.abs() || y.abs() != z.abs(),
        LocalTransform::Matrix(matrix) => {
            let m = &matrix.matrix3;
            let gram = m.transpose() * *m;
            let size = gram.x_axis.x;
            let differs = (gram - DMat3::from_diagonal(glam::DVec3::splat(size))).to_cols_array();
            differs.into_iter().any(|d| d.abs() > MAX_ROUNDING * size.abs())
        }
    }
}

/// The moments that may stretch nodes: keys of scales and rotations, and halfway between. A product
/// of scales, and a spline, may be largest between two keys.
fn moments(graph: &Graph, animations: &[Animation]) -> Vec<(usize, f64)> {
    let mut all = Vec::new();
    for (number, animation) in animations.iter().enumerate() {
        let stretches = |p: Property| matches!(p, Property::Scale | Property::Rotation);
        let is_in_graph = |node: u32| (node as usize) < graph.nodes.len();
        let channels = || {
            let of = animation.channels.iter();
            of.filter(move |c| stretches(c.property) && is_in_graph(c.node))
        };
        let mut times: Vec<f64> = channels().flat_map(|c| c.times.iter().copied()).collect();
        times.sort_unstable_by(f64::total_cmp);
        times.dedup();
        let scales = channels().filter(|c| c.property == Property::Scale);
        let mut scale_nodes = scales.clone().map(|c| c.node);
        let first = scale_nodes.next();
        // One node alone that is scaled from key to key is largest at a key.
        let is_at_keys = scale_nodes.all(|node| Some(node) == first)
            && channels().all(|c| {
                c.property == Property::Scale && c.interpolation != Interpolation::CubicSpline
            });
        let between: Vec<f64> = match is_at_keys {
            true => Vec::new(),
            false => times.windows(2).map(|pair| f64::midpoint(pair[0], pair[1])).collect(),
        };
        times.extend(between);
        times.sort_unstable_by(f64::total_cmp);
        all.extend(times.into_iter().map(|seconds| (number, seconds)));
    }
    let stride = all.len().div_ceil(MAX_MOMENTS).max(1);
    all.into_iter().step_by(stride).collect()
}
