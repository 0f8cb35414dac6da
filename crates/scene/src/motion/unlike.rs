//! Moments at which a node is stretched in unlike ways: few that stand for many.

use crate::transform::largest_stretch;
use glam::DMat3;
use lodc_mesh::PoseKey;

/// Most moments of one node that are kept. Chosen by hand: instances have all of them.
const MAX_KEPT: usize = 8;
/// A moment that stretches by no more than this times a kept one is not kept itself: the kept one
/// grows instead. Chosen by hand.
const MAX_GROWTH: f64 = 1.01;
/// Stretches that differ by a smaller share are the same. Chosen by hand.
pub(super) const MAX_ROUNDING: f64 = 1e-6;

/// How a node is stretched, at rest, at a moment or at all of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretched {
    /// None at rest.
    pub(super) moment: Option<PoseKey>,
    /// The linear part of its world transform there.
    pub(super) linear: DMat3,
    /// A linear part that makes no vector shorter than the node ever does; none where the moment
    /// stands for itself and what is like it.
    pub(super) envelope: Option<DMat3>,
    /// Distances in it are multiplied by this to hold for other moments, too.
    pub(super) growth: f64,
}

impl Stretched {
    /// The linear part that distances are measured in.
    pub(super) fn measured(&self) -> DMat3 {
        self.envelope.unwrap_or(self.linear)
    }
}

/// What stands for a node at rest and at all moments.
#[derive(Clone, Debug)]
pub(super) struct Stretches {
    pub(super) kept: Vec<Stretched>,
    /// False if animations have too many keys for all to be looked at.
    pub(super) is_whole: bool,
}

/// The moments of a node that stand for all that were added.
pub(super) struct Unlike {
    pub(super) kept: Vec<Stretched>,
}

impl Unlike {
    pub(super) fn at_rest(linear: DMat3) -> Self {
        Self { kept: vec![Stretched { moment: None, linear, envelope: None, growth: 1.0 }] }
    }

    /// Adds a moment unless a kept one stands for it, and leaves out those that it stands for.
    /// Returns false if it would be one too many.
    ///
    /// What stands for a linear part stands for it with any instance: the map between both is the
    /// same.
    pub(super) fn add(&mut self, moment: PoseKey, linear: DMat3) -> bool {
        let (nearest, least) = self.nearest(&linear);
        if least <= 1.0 + MAX_ROUNDING {
            return true;
        }
        let grown = &mut self.kept[nearest].growth;
        if *grown * least <= MAX_GROWTH {
            *grown *= least;
            return true;
        }
        self.kept.retain(|one| factor(&linear, &one.linear) * one.growth > 1.0 + MAX_ROUNDING);
        self.kept.push(Stretched { moment: Some(moment), linear, envelope: None, growth: 1.0 });
        self.kept.len() <= MAX_KEPT
    }

    /// Returns whether a kept moment stands for a linear part.
    pub(super) fn bounds(&self, linear: &DMat3) -> bool {
        self.nearest(linear).1 <= 1.0 + MAX_ROUNDING
    }

    /// Returns which kept moment stands for a linear part best, and by how much more than that it
    /// stretches; the first that it does not exceed.
    fn nearest(&self, linear: &DMat3) -> (usize, f64) {
        let mut nearest = (0, f64::INFINITY);
        for (number, one) in self.kept.iter().enumerate() {
            let least = factor(&one.linear, linear) / one.growth;
            if least < nearest.1 {
                nearest = (number, least);
            }
            if least <= 1.0 {
                break;
            }
        }
        nearest
    }
}

/// By what distances that one linear part leaves are multiplied to bound those that another does.
pub(super) fn factor(from: &DMat3, to: &DMat3) -> f64 {
    let map = *to * from.inverse();
    let factor = if map.is_finite() { largest_stretch(&map) } else { f64::INFINITY };
    // A matrix without an inverse stands for itself and for what vanishes.
    if factor.is_finite() || largest_stretch(to) > 0.0 { factor } else { 0.0 }
}
