//! The placements of an object that its errors are measured in: few that stand for all of them, at
//! rest and where animations stretch them otherwise.
//!
//! Let A and B be the linear parts of two placements of an object, and M = A B⁻¹. A level that is
//! within d of the object where B places both is within σ(M) d of it where A does, σ being the
//! largest singular value: M takes each surface to the other placement, and no vector becomes more
//! than σ(M) times as long. So one placement stands for all that are its images under maps that
//! stretch nothing. Joints are compared in the same way: one map must take each to the other's.

use super::Motion;
use super::unlike::MAX_ROUNDING;
use crate::placement::Placement;
use crate::scale::PlacementScales;
use crate::shape::Shape;
use crate::transform::{Transform, largest_stretch};
use glam::DMat3;
use lodc_mesh::{Mesh, PoseKey};
use std::sync::Arc;

/// Most placements of an object in which it is measured. Chosen by hand: each takes as long as a
/// pose.
const MAX_PLACEMENTS: usize = 8;

/// One placement stands for another if that is its image under a map that stretches by at most
/// this factor. Chosen by hand: the bound becomes larger by no more.
const MAX_LOOSENESS: f64 = 1.05;

/// Matrices of larger condition are not inverted. Chosen by hand: the rounding of doubles times
/// this is below [`MAX_ROUNDING`].
const MAX_CONDITION: f64 = 1e9;

/// The placements of an object that its errors are measured in.
#[derive(Clone, Debug)]
pub struct MeasuredPlacements {
    /// The placement of largest scale, the first of equals, then those that it does not stand for;
    /// none if nothing shows the object at a scale that is a finite number above 0.
    pub placements: Vec<MeasuredPlacement>,
    /// World units per mesh unit: the largest scale of any placement, at rest or at any moment; 1
    /// without one. Finite and above 0.
    pub scale: f64,
    /// At least 1: an error in mesh units times the scale of any one placement times this bounds
    /// what that placement errs. It is 1 if the placement of largest scale stretches nothing
    /// unevenly.
    pub unevenness: f64,
    /// How many times too large an error may be because a placement stands for others: at least 1,
    /// and at most 1.05 unless there are too many unlike ones for each to be measured.
    pub looseness: f64,
    /// False if animations stretch it at more moments than are looked at, so that it may err more
    /// at others.
    pub is_whole: bool,
}

/// A placement that an object's errors are measured in.
#[derive(Clone, Debug)]
pub struct MeasuredPlacement {
    /// The placement, at its moment.
    pub placement: Placement,
    /// The number of its placement at rest, among those of the object.
    pub rest: usize,
    /// How its node is stretched in it.
    pub stretch: Stretch,
    /// Distances in it are multiplied by this, at least 1, to hold for all that it stands for.
    pub growth: f64,
}

/// How a node is stretched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stretch {
    /// As at rest.
    AtRest,
    /// As at a moment of an animation.
    At(PoseKey),
    /// By this linear part instead of its world transform's, which makes no vector shorter than
    /// that does at rest or at any moment.
    Envelope(DMat3),
}

impl MeasuredPlacement {
    /// The shape of the object. `scale` is [`MeasuredPlacements::scale`]. None if coordinates are
    /// not finite.
    pub(crate) fn shape(&self, mesh: &Mesh, scale: f64) -> Option<Shape> {
        Shape::shown(mesh, &self.placement, scale / self.growth)
    }
}

impl Motion {
    /// The placements that an object's errors are measured in: at most eight. `mesh` is the object
    /// at full detail.
    #[must_use]
    pub fn measured_placements(&self, mesh: &Mesh, object: usize) -> MeasuredPlacements {
        let candidates = self.placement_candidates(mesh, object);
        let (chosen, factors) = stand_ins(&candidates);
        let at_rest: Vec<&Placement> = self.rest.of(object).collect();
        let measured = |&(number, growth): &(usize, f64)| {
            let Candidate { rest, stretch, .. } = candidates[number];
            let placement = at_rest[rest].clone();
            let own = MeasuredPlacement { placement, rest, stretch, growth };
            Some(MeasuredPlacement { placement: self.stretched_as(&own, at_rest[rest])?, ..own })
        };
        let is_whole = |placement: &Placement| {
            let stretches = placement.node.and_then(|node| self.stretching.nodes.get(&node));
            stretches.is_none_or(|stretches| stretches.is_whole)
        };
        let scale = chosen.first().map_or(1.0, |&(first, _)| candidates[first].scale);
        let of_own = factors.iter().zip(&candidates).map(|(factor, c)| factor * scale / c.shown);
        MeasuredPlacements {
            placements: chosen.iter().filter_map(measured).collect(),
            scale,
            unevenness: of_own.fold(1.0, f64::max).min(MAX_UNEVENNESS),
            looseness: chosen.iter().fold(1.0, |most, &(_, growth)| most.max(growth)),
            is_whole: self.rest.of(object).all(is_whole),
        }
    }

    /// Every placement of an object at rest, and those at moments that may matter besides.
    fn placement_candidates(&self, mesh: &Mesh, object: usize) -> Vec<Candidate> {
        let mut scales = PlacementScales::new(mesh);
        let mut candidates = Vec::new();
        let mut add = |candidate: Candidate| {
            // A scale of 0 or infinity says nothing about where detail is needed.
            if candidate.scale.is_finite() && candidate.scale > 0.0 {
                candidates.push(candidate);
            }
        };
        for (number, placement) in self.rest.of(object).enumerate() {
            let scale = scales.of(placement);
            let rest = Candidate {
                rest: number,
                stretch: Stretch::AtRest,
                linear: placement.transform.matrix3,
                // Of a moment's placement that stands for others.
                growth: 1.0,
                joints: Arc::clone(&placement.joints),
                weights: Arc::clone(&placement.weights),
                scale,
                shown: scale,
            };
            if !placement.joints.is_empty() {
                let skin = placement.node.and_then(|n| self.graph.nodes[n as usize].skin);
                let moment = skin.and_then(|skin| {
                    let joints = self.stretching.joints.get(&skin)?;
                    scales.largest_moment(placement, joints)
                });
                let at_moment = moment.and_then(|moment| {
                    let at = self.shown_at(placement, moment)?;
                    let (scale, joints) = (scales.of(&at), at.joints);
                    let stretch = Stretch::At(moment);
                    Some(Candidate { stretch, joints, scale, shown: scale, ..rest.clone() })
                });
                at_moment.into_iter().for_each(&mut add);
                add(rest);
                continue;
            }
            match placement.node.and_then(|node| self.stretching.nodes.get(&node)) {
                None => add(rest),
                Some(stretches) => {
                    let instance = self.instance(placement).matrix3;
                    for one in &stretches.kept {
                        let linear = one.measured() * instance;
                        let stretch = match (one.envelope, one.moment) {
                            (Some(all), _) => Stretch::Envelope(all),
                            (None, Some(moment)) => Stretch::At(moment),
                            (None, None) => Stretch::AtRest,
                        };
                        let scale = one.growth * largest_stretch(&linear);
                        let shown = match one.envelope {
                            Some(_) => largest_stretch(&(one.linear * instance)),
                            None => scale,
                        };
                        let growth = one.growth;
                        add(Candidate { stretch, linear, growth, scale, shown, ..rest.clone() });
                    }
                }
            }
        }
        candidates
    }
}

/// A placement that may be measured.
#[derive(Clone)]
struct Candidate {
    /// The number of its placement at rest.
    rest: usize,
    stretch: Stretch,
    linear: DMat3,
    /// Distances in it are multiplied by this.
    growth: f64,
    joints: Arc<[Transform]>,
    weights: Arc<[f64]>,
    /// World units per mesh unit, with `growth`.
    scale: f64,
    /// World units per mesh unit where it is shown largest.
    shown: f64,
}

/// The limit of [`MeasuredPlacements::unevenness`], met where a placement is a sheet beside others
/// that are none.
const MAX_UNEVENNESS: f64 = 1e6;

/// Chooses candidates that stand for all, the one of largest scale first, then always the one that
/// those chosen stand for least (Gonzalez 1985). Returns them with what distances in them are to be
/// multiplied by, and for each candidate a bound of its distances relative to those of the first.
fn stand_ins(candidates: &[Candidate]) -> (Vec<(usize, f64)>, Vec<f64>) {
    let mut chosen: Vec<(usize, f64)> = Vec::new();
    // Of each candidate the least factor from a chosen one, and which that is.
    let mut least = vec![(f64::INFINITY, 0); candidates.len()];
    let largest = |a: usize, b: usize| {
        // Of those that are stretched as much the one that is stretched more in other directions,
        // else the first.
        let size = |i: usize| {
            let Candidate { linear, growth, .. } = &candidates[i];
            linear.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt() * growth
        };
        let exceeds = |b: f64, a: f64| b > a * (1.0 + MAX_ROUNDING);
        let [of_a, of_b] = [a, b].map(|i| candidates[i].scale);
        let is_equal = !exceeds(of_a, of_b);
        if exceeds(of_b, of_a) || is_equal && exceeds(size(b), size(a)) { b } else { a }
    };
    let mut next = (0..candidates.len()).reduce(largest);
    while let Some(number) = next.filter(|_| chosen.len() < MAX_PLACEMENTS) {
        let stand_in = StandIn::new(&candidates[number]);
        for (least, candidate) in least.iter_mut().zip(candidates) {
            let factor = stand_in.factor(candidate);
            if factor < least.0 {
                *least = (factor, chosen.len());
            }
        }
        least[number] = (1.0, chosen.len());
        chosen.push((number, 1.0));
        let farthest = least.iter().enumerate().max_by(|a, b| {
            // The first of equals, and of those that none stands for the largest.
            let key = |&(i, &(factor, _)): &(usize, &(f64, usize))| (factor, candidates[i].scale);
            let (a_key, b_key) = (key(a), key(b));
            a_key.0.total_cmp(&b_key.0).then(a_key.1.total_cmp(&b_key.1)).then(b.0.cmp(&a.0))
        });
        next = farthest.filter(|(_, (factor, _))| *factor > MAX_LOOSENESS).map(|(i, _)| i);
    }
    for &(factor, by) in &least {
        // What none of them stands for has another shape: other weights, other poses of joints.
        if factor.is_finite() && factor > 1.0 + MAX_ROUNDING {
            chosen[by].1 = chosen[by].1.max(factor);
        }
    }
    let relative = |&(factor, by): &(f64, usize)| {
        let growth = chosen.get(by).map_or(1.0, |c| c.1);
        if factor.is_finite() { (factor / growth).min(1.0) } else { 1.0 }
    };
    let factors = least.iter().map(relative).collect();
    for (number, growth) in &mut chosen {
        *growth *= candidates[*number].growth;
    }
    (chosen, factors)
}

/// A candidate that may stand for others.
struct StandIn<'a> {
    candidate: &'a Candidate,
    /// The inverse of its linear part; none of one that flattens everything.
    inverse: Option<DMat3>,
    /// Likewise the inverse of its first joint.
    joint_inverse: Option<Transform>,
}

impl<'a> StandIn<'a> {
    fn new(candidate: &'a Candidate) -> Self {
        let joint_inverse = candidate.joints.first().and_then(|joint| {
            let inverse = joint.inverse();
            (inverts(&joint.matrix3) && inverse.is_finite()).then_some(inverse)
        });
        let inverse = inverts(&candidate.linear).then(|| candidate.linear.inverse());
        Self { candidate, inverse, joint_inverse }
    }

    /// By what distances in this placement are multiplied to bound those in another; infinite if no
    /// number does.
    fn factor(&self, other: &Candidate) -> f64 {
        let own = self.candidate;
        let same_weights =
            Arc::ptr_eq(&own.weights, &other.weights) || own.weights == other.weights;
        if !same_weights || own.joints.len() != other.joints.len() {
            return f64::INFINITY;
        }
        let growth = other.growth / own.growth;
        if !own.joints.is_empty() {
            return growth * self.joint_factor(&other.joints);
        }
        match self.inverse {
            Some(inverse) => growth * largest_stretch(&(other.linear * inverse)),
            None => growth * multiple(&own.linear, &other.linear),
        }
    }

    fn joint_factor(&self, other: &Arc<[Transform]>) -> f64 {
        let own = &self.candidate.joints;
        if Arc::ptr_eq(own, other) {
            return 1.0;
        }
        let Some(inverse) = self.joint_inverse else { return f64::INFINITY };
        let map = other[0] * inverse;
        let size =
            |t: &Transform| t.to_cols_array().into_iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let maps = own.iter().zip(&**other).all(|(from, to)| {
            let mapped = map * *from;
            let differ = mapped.to_cols_array().into_iter().zip(to.to_cols_array());
            let allowed = MAX_ROUNDING * size(to).max(size(&mapped));
            differ.map(|(a, b)| (a - b).abs()).all(|d| d <= allowed)
        });
        if maps { largest_stretch(&map.matrix3) } else { f64::INFINITY }
    }
}

/// Returns whether a matrix has an inverse that can be computed with.
fn inverts(m: &DMat3) -> bool {
    let inverse_stretch = largest_stretch(&m.inverse());
    let condition = largest_stretch(m) * inverse_stretch;
    condition.is_finite() && condition < MAX_CONDITION
}

/// The factor between two matrices that flatten alike, up to a rotation afterwards; infinite for
/// others.
fn multiple(from: &DMat3, to: &DMat3) -> f64 {
    let (a, b) = (largest_stretch(from), largest_stretch(to));
    let ratio = b / a;
    let gram = |m: &DMat3, size: f64| {
        let m = *m * (1.0 / size);
        (m.transpose() * m).to_cols_array()
    };
    let same =
        gram(from, a).into_iter().zip(gram(to, b)).all(|(x, y)| (x - y).abs() <= MAX_ROUNDING);
    if same { ratio } else { f64::INFINITY }
}

#[cfg(test)]
#[path = "measured_tests.rs"]
mod tests;
