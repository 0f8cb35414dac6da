//! Moments of animations at which nodes and joints stretch otherwise than at rest.

use super::course::{Animated, Course, Link};
use super::unlike::{Stretched, Stretches};
use crate::animation::{Animation, Channel, Interpolation, Property};
use crate::graph::Graph;
use crate::transform::{LocalTransform, Transform, largest_stretch};
use glam::DMat3;
use lodc_mesh::PoseKey;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Most moments of all animations together at which joints are looked at, and of one node if there
/// are many. Chosen by hand.
const MAX_MOMENTS: usize = 512;
/// Most moments of one node. Chosen by hand: a tenth of a second.
const MAX_MOMENTS_OF_ONE: usize = 16_384;
/// Most moments of all nodes together, as long as each has `MAX_MOMENTS`. Chosen by hand: some
/// seconds.
const MAX_MOMENTS_IN_ALL: usize = 1 << 16;
/// Moments that are looked at together. Chosen by hand: bounds the memory.
const MOMENTS_AT_ONCE: usize = 16;
/// Scales along axes that differ by a smaller share are even. Chosen by hand: what exporters make
/// of an even scale, by way of matrices of floats.
const MAX_UNEVEN_ROUNDING: f64 = 1e-5;

/// Where animations stretch nodes and joints otherwise than at rest.
#[derive(Clone, Debug, Default)]
pub(super) struct Stretching {
    /// By node that shows objects, without a skin: linear parts that stand for those at rest and at
    /// all moments. Nodes that are stretched as at rest are not here.
    pub(super) nodes: BTreeMap<u32, Stretches>,
    /// By skin and joint: the moment at which the joint stretches most, and by how much; none where
    /// no moment stretches it more than at rest.
    pub(super) joints: BTreeMap<u32, Vec<Option<(f64, PoseKey)>>>,
}

impl Stretching {
    pub(super) fn new(graph: &Graph, animations: &[Animation]) -> Self {
        let affected = affected(graph, animations);
        if !affected.iter().any(Affected::is_affected) {
            return Self::default();
        }
        Self {
            nodes: nodes(graph, animations, &affected),
            joints: joints(graph, animations, &affected),
        }
    }
}

/// Nodes that show objects without a skin and are stretched otherwise than at rest.
fn nodes(
    graph: &Graph,
    animations: &[Animation],
    affected: &[Affected],
) -> BTreeMap<u32, Stretches> {
    let shows = |n: &usize| {
        let node = &graph.nodes[*n];
        affected[*n].is_affected() && !node.objects.is_empty() && node.skin.is_none()
    };
    let nodes: Vec<usize> = (0..graph.nodes.len()).filter(shows).collect();
    // What hangs below the same node, and is not animated itself, is stretched with it.
    let carriers: BTreeSet<usize> = nodes.iter().filter_map(|&n| affected[n].carrier).collect();
    let max_moments = MAX_MOMENTS_IN_ALL / carriers.len().max(1);
    let max_moments = max_moments.clamp(MAX_MOMENTS, MAX_MOMENTS_OF_ONE);
    let rest = graph.world_transforms(&graph.rest_pose());
    let channels = Channels::new(graph, animations);
    let stretched = |&carrier: &usize| {
        let course = channels.course(graph, affected, carrier);
        course.stretched(rest[carrier].matrix3, animations.len(), max_moments)
    };
    let carriers: Vec<usize> = carriers.into_iter().collect();
    let of_carriers: Vec<Stretches> = carriers.par_iter().map(stretched).collect();
    let of_node = |n: usize| {
        let number = carriers.binary_search(&affected[n].carrier?).ok()?;
        let Stretches { kept, is_whole } = &of_carriers[number];
        let below = path(affected, affected[n].carrier?, n);
        let carried = |linear: DMat3| {
            below.iter().fold(linear, |above, &m| above * graph.nodes[m].local.matrix().matrix3)
        };
        let stretched = |one: &Stretched| Stretched {
            linear: carried(one.linear),
            envelope: one.envelope.map(carried),
            ..*one
        };
        let kept: Vec<Stretched> = kept.iter().map(stretched).collect();
        let is_as_at_rest =
            matches!(kept[..], [Stretched { moment: None, envelope: None, growth: 1.0, .. }]);
        (!is_as_at_rest).then_some((n as u32, Stretches { kept, is_whole: *is_whole }))
    };
    nodes.into_iter().filter_map(of_node).collect()
}

/// The nodes below one node, down to another.
fn path(affected: &[Affected], above: usize, node: usize) -> Vec<usize> {
    let up = std::iter::successors(Some(node), |&n| affected[n].parent);
    let mut path: Vec<usize> = up.take_while(|&n| n != above).collect();
    path.reverse();
    path
}

/// The scales and rotations that animations change, by node.
struct Channels<'a> {
    by_node: Vec<Vec<(usize, &'a Channel)>>,
}

impl<'a> Channels<'a> {
    fn new(graph: &Graph, animations: &'a [Animation]) -> Self {
        let mut by_node = vec![Vec::new(); graph.nodes.len()];
        for (number, animation) in animations.iter().enumerate() {
            for channel in &animation.channels {
                let turns_or_scales =
                    matches!(channel.property, Property::Scale | Property::Rotation);
                if let Some(of_node) = by_node.get_mut(channel.node as usize)
                    && turns_or_scales
                {
                    of_node.push((number, channel));
                }
            }
        }
        Self { by_node }
    }

    /// All that moves a node and those above it.
    fn course(&self, graph: &Graph, affected: &[Affected], node: usize) -> Course<'a> {
        let mut up: Vec<usize> =
            std::iter::successors(Some(node), |&n| affected[n].parent).collect();
        up.reverse();
        let link = |&n: &usize| {
            let animated = |&(animation, channel): &(usize, &'a Channel)| {
                let stretches = match channel.property {
                    Property::Scale => affected[n].is_scaled,
                    _ => affected[n].is_turned,
                };
                Animated { animation, channel, stretches }
            };
            let animated = self.by_node[n].iter().map(animated).collect();
            Link { local: graph.nodes[n].local, animated }
        };
        Course { links: up.iter().map(link).collect() }
    }
}

/// By skin that an animation may stretch the moment at which each of its joints is largest.
fn joints(
    graph: &Graph,
    animations: &[Animation],
    affected: &[Affected],
) -> BTreeMap<u32, Vec<Option<(f64, PoseKey)>>> {
    let is_affected = |&s: &usize| {
        let joints = &graph.skins[s].joints;
        joints.iter().any(|&j| affected.get(j as usize).is_some_and(Affected::is_affected))
    };
    let skins: Vec<usize> = (0..graph.skins.len()).filter(is_affected).collect();
    if skins.is_empty() {
        return BTreeMap::new();
    }
    let mut of_skins: Vec<Vec<Option<(f64, PoseKey)>>> =
        skins.iter().map(|&s| vec![None; graph.skins[s].joints.len()]).collect();
    for some in moments(graph, animations).chunks(MOMENTS_AT_ONCE) {
        let world_at = |&(animation, seconds): &(usize, f64)| {
            let pose = animations[animation].pose(graph, seconds);
            (
                PoseKey::Moment { animation: animation as u32, seconds },
                graph.world_transforms(&pose),
            )
        };
        let worlds: Vec<(PoseKey, Vec<Transform>)> = some.par_iter().map(world_at).collect();
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
    skins.into_iter().map(|s| s as u32).zip(of_skins).collect()
}

/// How animations may stretch a node otherwise than at rest.
#[derive(Clone, Copy, Debug, Default)]
struct Affected {
    parent: Option<usize>,
    /// Whether its scale changes.
    is_scaled: bool,
    /// Whether it turns below a node that stretches unevenly.
    is_turned: bool,
    /// The lowest node that is one of both, of itself and those above it.
    carrier: Option<usize>,
}

impl Affected {
    fn is_affected(&self) -> bool {
        self.carrier.is_some()
    }
}

/// Returns for each node how animations may stretch it.
fn affected(graph: &Graph, animations: &[Animation]) -> Vec<Affected> {
    let nodes = graph.nodes.len();
    let (mut scaled, mut turned) = (vec![false; nodes], vec![false; nodes]);
    let mut scaled_unevenly = vec![false; nodes];
    for channel in animations.iter().flat_map(|a| &a.channels) {
        let n = channel.node as usize;
        match channel.property {
            Property::Scale if n < nodes => {
                scaled[n] = true;
                scaled_unevenly[n] |= channel.values.chunks_exact(3).any(is_uneven);
            }
            Property::Rotation if n < nodes => turned[n] = true,
            _ => {}
        }
    }
    let mut affected = vec![Affected::default(); nodes];
    let mut uneven = vec![false; nodes];
    for visit in graph.walk(graph.topmost().into_iter()) {
        let n = visit.node;
        let is_below_uneven = visit.parent.is_some_and(|parent| uneven[parent]);
        let is_turned = turned[n] && is_below_uneven;
        let above = visit.parent.and_then(|parent| affected[parent].carrier);
        affected[n] = Affected {
            parent: visit.parent,
            is_scaled: scaled[n],
            is_turned,
            carrier: (scaled[n] || is_turned).then_some(n).or(above),
        };
        uneven[n] =
            is_below_uneven || scaled_unevenly[n] || stretches_unevenly(&graph.nodes[n].local);
    }
    affected
}

/// Returns whether the three numbers of a scale differ by more than rounding.
fn is_uneven(scale: &[f64]) -> bool {
    let sizes = scale.iter().map(|s| s.abs());
    let (low, high) = sizes.fold((f64::INFINITY, 0.0f64), |(lo, hi), s| (lo.min(s), hi.max(s)));
    high - low > MAX_UNEVEN_ROUNDING * high
}

fn stretches_unevenly(local: &LocalTransform) -> bool {
    match local {
        LocalTransform::Trs { scale, .. } => is_uneven(scale),
        LocalTransform::Matrix(matrix) => {
            let m = &matrix.matrix3;
            let gram = m.transpose() * *m;
            let size = gram.x_axis.x;
            let differs = (gram - DMat3::from_diagonal(glam::DVec3::splat(size))).to_cols_array();
            differs.into_iter().any(|d| d.abs() > 2.0 * MAX_UNEVEN_ROUNDING * size.abs())
        }
    }
}

/// The moments that may stretch joints: keys of scales and rotations, and halfway between. A
/// product of scales, and a spline, may be largest between two keys.
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
