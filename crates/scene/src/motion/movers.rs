//! The placements of an object that moments of animations give shapes of their own: nodes with
//! other skins, and those whose morph weights are animated.

use super::{MeasuredPlacements, Moment, Motion};
use crate::graph::Graph;
use crate::placement::Placement;
use crate::transform::Transform;
use glam::DVec3;
use std::sync::Arc;

/// Most placements of an object that are looked at in each moment. Chosen by hand.
const MAX_MOVERS: usize = 8;

/// A placement of an object at rest, or in a pose key.
#[derive(Clone, Debug)]
pub(super) struct Mover {
    pub(super) placement: Placement,
    /// Distances in its pose keys are multiplied by this, at least 1, to hold for all placements
    /// that it stands for.
    pub(super) growth: f64,
}

impl Motion {
    /// The placements of an object that pose keys change: first that of largest scale, the only one
    /// in poses of morph targets, then those that [move by themselves](Self::movers_besides).
    ///
    /// With joints each is as it is placed. Without, all have the transform of the one measured
    /// placement; if several are measured, only the largest scale, which stretches no pose key less
    /// than any placement does.
    pub(super) fn movers(&self, object: usize, measured: &MeasuredPlacements) -> Vec<Mover> {
        let Some(first) = measured.placements.first() else { return Vec::new() };
        let (transform, growth) = if measured.placements.len() == 1 {
            (first.placement.transform, first.growth)
        } else {
            (Transform::from_scale(DVec3::splat(measured.scale)), 1.0)
        };
        let mover = |rest: &Placement| {
            if rest.joints.is_empty() {
                Mover { placement: Placement { transform, ..rest.clone() }, growth }
            } else {
                Mover { placement: rest.clone(), growth: first.growth }
            }
        };
        let besides = self.movers_besides(object, first.rest);
        let at_rest: Vec<&Placement> = self.rest.of(object).collect();
        let wanted = std::iter::once(first.rest).chain(besides);
        wanted.filter_map(|number| at_rest.get(number).copied()).map(mover).collect()
    }

    /// The placements of an object at rest, by number, that moments of animations may give other
    /// shapes than to the placement `first`, and than to each other: at most seven, of nodes with
    /// another skin, or whose morph weights an animation changes.
    #[must_use]
    pub fn movers_besides(&self, object: usize, first: usize) -> Vec<usize> {
        // What moves a placement; none of one that nothing gives another shape.
        let movement = |placement: &Placement| {
            let node = placement.node?;
            let morphed = self.morphed.contains(&node).then_some(node);
            let skin =
                self.graph.nodes[node as usize].skin.filter(|_| !placement.joints.is_empty());
            let moves = morphed.is_some() || skin.is_some();
            moves.then(|| (skin, morphed, Arc::clone(&placement.weights)))
        };
        let mut known: Vec<_> = self.rest.of(object).nth(first).map(movement).into_iter().collect();
        let mut numbers = Vec::new();
        for (number, placement) in self.rest.of(object).enumerate() {
            if known.len() >= MAX_MOVERS {
                break;
            }
            let own = movement(placement);
            if own.is_some() && !known.contains(&own) {
                known.push(own);
                numbers.push(number);
            }
        }
        numbers
    }
}

impl Moment {
    /// Returns placements at this moment: the first of them, and those that have another shape than
    /// at rest and than those before them.
    pub(super) fn all_placed(&self, graph: &Graph, movers: &[Mover]) -> Vec<Mover> {
        let same = |a: &Placement, b: &Placement| a.joints == b.joints && a.weights == b.weights;
        let mut placed: Vec<Mover> = Vec::with_capacity(movers.len());
        for mover in movers {
            let placement = self.placed(graph, &mover.placement);
            let is_new = !same(&placement, &mover.placement)
                && !placed.iter().any(|before| same(&placement, &before.placement));
            if placed.is_empty() || is_new {
                placed.push(Mover { placement, growth: mover.growth });
            }
        }
        placed
    }
}
