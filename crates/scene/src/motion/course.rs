//! How a node is stretched in the course of animations: few moments that stand for all, or an
//! envelope of all.
//!
//! Any vector v of the object is as long as |L(t) v| at the moment t, L(t) being the linear part of
//! the node's world transform. While nodes turn evenly, by θ in all from one moment to the next,
//! the square of that length is a sum of sines whose phases advance by at most 2 θ, so that where
//! it is largest it is at most 1 / cos²(θ / 2) times what it is at the nearer of both (Duffin and
//! Schaeffer 1938), however uneven the scales between these nodes are. So moments that are close by
//! angle bound all others, and what else changes lengths is looked for halfway between them.

use super::envelope::envelope;
use super::unlike::{MAX_ROUNDING, Stretched, Stretches, Unlike, factor};
use crate::animation::{Channel, Interpolation, Property};
use crate::transform::{LocalTransform, largest_stretch};
use glam::{DMat3, DVec4};
use lodc_mesh::PoseKey;

/// Nodes turn by at most this from one moment to the next, in radians, before what is halfway is
/// looked at. Chosen by hand: what may be missed is half a percent.
const MAX_TURN: f64 = 0.4;
/// Most halvings between two keys that are looked at. Chosen by hand.
const MAX_HALVINGS: u32 = 16;
/// Between two moments lengths may exceed an envelope by this share. Chosen by hand: what exceeds
/// it makes it larger.
const MAX_EXCESS: f64 = 1e-3;
/// Most envelopes that are tried. Chosen by hand.
const MAX_ENVELOPES: usize = 2;

/// The nodes from the topmost one to one that an animation stretches.
pub(super) struct Course<'a> {
    pub(super) links: Vec<Link<'a>>,
}

/// A node, and what animations change of it.
pub(super) struct Link<'a> {
    pub(super) local: LocalTransform,
    pub(super) animated: Vec<Animated<'a>>,
}

/// A scale or a rotation that an animation changes.
#[derive(Clone, Copy)]
pub(super) struct Animated<'a> {
    pub(super) animation: usize,
    pub(super) channel: &'a Channel,
    /// Whether nodes below are stretched otherwise by it.
    pub(super) stretches: bool,
}

/// A moment, and the linear part of the node's world transform there.
#[derive(Clone, Copy)]
struct Sample {
    animation: usize,
    seconds: f64,
    linear: DMat3,
}

impl Sample {
    fn pose_key(&self) -> PoseKey {
        PoseKey::Moment { animation: self.animation as u32, seconds: self.seconds }
    }
}

impl Course<'_> {
    /// Returns what stands for the node at rest and at all moments of some animations; not whole if
    /// there are more keys than `max_moments`.
    pub(super) fn stretched(
        &self,
        rest: DMat3,
        animations: usize,
        max_moments: usize,
    ) -> Stretches {
        let mut is_whole = true;
        let mut samples = Vec::new();
        for animation in 0..animations {
            let (moments, is_all) = self.moments(animation, max_moments);
            is_whole &= is_all;
            let linear = |seconds| self.linear(animation, seconds);
            let sample = |seconds| Sample { animation, seconds, linear: linear(seconds) };
            samples.extend(moments.into_iter().map(sample).filter(|s| s.linear.is_finite()));
        }
        let mut unlike = Unlike::at_rest(rest);
        let few = samples.iter().all(|s| unlike.add(s.pose_key(), s.linear));
        let few = few && {
            let add = |s: &Sample| match unlike.bounds(&s.linear) {
                true => Some(false),
                false => unlike.add(s.pose_key(), s.linear).then_some(true),
            };
            self.look_between(&samples, max_moments, add)
        };
        if !few {
            let all = self.enveloped(rest, &samples, max_moments);
            return Stretches { kept: all.map_or(unlike.kept, |all| vec![all]), is_whole };
        }
        let is_as_at_rest =
            matches!(unlike.kept[..], [Stretched { moment: None, growth: 1.0, .. }]);
        if self.turns() && !is_as_at_rest {
            unlike.kept.iter_mut().for_each(|one| one.growth *= growth_between(MAX_TURN / 2.0));
        }
        Stretches { kept: unlike.kept, is_whole }
    }

    /// Calls `add` with what is halfway between neighbouring moments, and again on both sides of it
    /// where it says true. Returns false as soon as it says none.
    fn look_between(
        &self,
        samples: &[Sample],
        max_moments: usize,
        mut add: impl FnMut(&Sample) -> Option<bool>,
    ) -> bool {
        let mut remaining = max_moments;
        for pair in samples.windows(2).filter(|pair| pair[0].animation == pair[1].animation) {
            let animation = pair[0].animation;
            let mut intervals = vec![([pair[0].seconds, pair[1].seconds], MAX_HALVINGS)];
            while let Some(([from, to], halvings)) = intervals.pop() {
                let seconds = f64::midpoint(from, to);
                if seconds <= from || seconds >= to {
                    continue;
                }
                let sample = Sample { animation, seconds, linear: self.linear(animation, seconds) };
                if !sample.linear.is_finite() {
                    continue;
                }
                match add(&sample) {
                    None => return false,
                    Some(true) if halvings > 0 && remaining > 0 => {
                        remaining -= 1;
                        intervals.push(([seconds, to], halvings - 1));
                        intervals.push(([from, seconds], halvings - 1));
                    }
                    Some(_) => {}
                }
            }
        }
        true
    }

    /// An envelope of all moments, with the one that stretches most; none if nothing has a size.
    fn enveloped(&self, rest: DMat3, samples: &[Sample], max_moments: usize) -> Option<Stretched> {
        let mut parts: Vec<DMat3> = samples.iter().map(|s| s.linear).collect();
        parts.extend(rest.is_finite().then_some(rest));
        let mut all = envelope(&parts)?;
        let mut growth = 1.0f64;
        for round in 1..=MAX_ENVELOPES {
            let known = parts.len();
            growth = 1.0;
            self.look_between(samples, max_moments, |s| {
                let excess = factor(&all, &s.linear);
                growth = growth.max(excess);
                let exceeds = excess > 1.0 + MAX_EXCESS;
                parts.extend(exceeds.then_some(s.linear));
                Some(exceeds)
            });
            if parts.len() == known || round == MAX_ENVELOPES {
                break;
            }
            all = envelope(&parts)?;
        }
        if self.turns() {
            growth *= growth_between(MAX_TURN / 2.0);
        }
        let (mut largest, mut at) = (largest_stretch(&rest), (None, rest));
        for sample in samples {
            let stretch = largest_stretch(&sample.linear);
            if stretch > largest * (1.0 + MAX_ROUNDING) || !largest.is_finite() {
                (largest, at) = (stretch, (Some(sample.pose_key()), sample.linear));
            }
        }
        let (moment, linear) = at;
        Some(Stretched { moment, linear, envelope: Some(all), growth })
    }

    /// The moments of an animation that are looked at first: its keys, with what is right before
    /// those of steps, eighths between those of splines, and so many between that nodes turn little
    /// from one to the next. Returns whether these are all.
    fn moments(&self, animation: usize, max_moments: usize) -> (Vec<f64>, bool) {
        let mut times = Vec::new();
        for Animated { channel, .. } in self.stretching(animation) {
            times.extend(&channel.times);
            match channel.interpolation {
                Interpolation::Linear => {}
                Interpolation::Step => {
                    times.extend(channel.times.iter().skip(1).map(|time| time.next_down()));
                }
                Interpolation::CubicSpline => {
                    let eighth =
                        |pair: &[f64], i: i32| pair[0] + (pair[1] - pair[0]) * f64::from(i) / 8.0;
                    let pairs = channel.times.windows(2);
                    times.extend(pairs.flat_map(|pair| (1..8).map(|i| eighth(pair, i))));
                }
            }
        }
        times.sort_unstable_by(f64::total_cmp);
        times.dedup();
        let stride = times.len().div_ceil(max_moments).max(1);
        let times: Vec<f64> = times.into_iter().step_by(stride).collect();
        let mut is_all = stride == 1;
        let mut moments = Vec::with_capacity(times.len());
        moments.extend(times.first());
        for pair in times.windows(2) {
            let mut ends = vec![(pair[1], MAX_HALVINGS)];
            while let (Some(&from), Some((to, halvings))) = (moments.last(), ends.pop()) {
                let turns_much = self.turn(animation, [from, to]) > MAX_TURN;
                let is_last = halvings == 0 || moments.len() >= 2 * max_moments;
                if turns_much && !is_last {
                    ends.push((to, halvings - 1));
                    ends.push((f64::midpoint(from, to), halvings - 1));
                } else {
                    is_all &= !turns_much;
                    moments.push(to);
                }
            }
        }
        (moments, is_all)
    }

    /// The scales and rotations of an animation by which the node is stretched.
    fn stretching(&self, animation: usize) -> impl Iterator<Item = &Animated<'_>> {
        let all = self.links.iter().flat_map(|link| &link.animated);
        all.filter(move |a| a.animation == animation && a.stretches)
    }

    /// Returns whether rotations stretch the node.
    fn turns(&self) -> bool {
        let mut all = self.links.iter().flat_map(|link| &link.animated);
        all.any(|a| a.stretches && a.channel.property == Property::Rotation)
    }

    /// By how much nodes turn from one moment to another by way of that halfway, all together, in
    /// radians; quarter turns and more count for less.
    fn turn(&self, animation: usize, [from, to]: [f64; 2]) -> f64 {
        let turn = |Animated { channel, .. }: &Animated<'_>| {
            let is_rotation = channel.property == Property::Rotation;
            if !is_rotation || channel.interpolation == Interpolation::Step {
                return 0.0;
            }
            let at = |seconds| {
                let [x, y, z, w] = channel.at(seconds)?.try_into().ok()?;
                Some(DVec4::new(x, y, z, w).normalize_or_zero())
            };
            let [a, b, c] = [from, f64::midpoint(from, to), to].map(|t| at(t).unwrap_or_default());
            // The quaternions of a turn by θ are 2 sin(θ / 4) apart, or as far from the negative.
            let angle = |a: DVec4, b: DVec4| 2.0 * (a - b).length().min((a + b).length());
            angle(a, b) + angle(b, c)
        };
        self.stretching(animation).map(turn).sum()
    }

    /// The linear part of the node's world transform at a moment.
    fn linear(&self, animation: usize, seconds: f64) -> DMat3 {
        let mut world = DMat3::IDENTITY;
        for Link { local, animated } in &self.links {
            let mut local = *local;
            for a in animated.iter().filter(|a| a.animation == animation) {
                a.channel.apply_to(&mut local, seconds);
            }
            world *= local.matrix().matrix3;
        }
        world
    }
}

/// How many times as long as at the nearer of two moments a vector may become between them while
/// nodes turn by an angle: 1 / cos(angle / 2), rounded up.
fn growth_between(angle: f64) -> f64 {
    1.0 / (1.0 - angle * angle / 8.0)
}
