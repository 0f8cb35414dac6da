//! Animations: keyframes of nodes and morph weights, and the pose at a moment (glTF 2.0, 3.11 and
//! appendix C).

use crate::graph::Graph;
use crate::pose::Pose;
use crate::transform::LocalTransform;

/// Keyframes of several nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// The name in the file; may be empty.
    pub name: String,
    /// The properties of nodes that change.
    pub channels: Vec<Channel>,
}

/// Keyframes of one property of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Index of the node.
    pub node: u32,
    /// The part of it that changes.
    pub property: Property,
    /// The interpolation between keys.
    pub interpolation: Interpolation,
    /// The time of each key in seconds, rising.
    pub times: Vec<f64>,
    /// The values of the keys, one after another. For [`Interpolation::CubicSpline`] three values
    /// for each key: its incoming tangent, its value, its outgoing tangent.
    pub values: Vec<f64>,
}

/// A part of a node that an animation changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// Three numbers.
    Translation,
    /// A quaternion x, y, z, w.
    Rotation,
    /// Three numbers.
    Scale,
    /// A number for each morph target.
    Weights,
    /// The number of one morph target.
    Weight(u32),
}

impl Property {
    /// Returns whether it concerns morph targets.
    #[must_use]
    pub fn is_of_targets(self) -> bool {
        matches!(self, Self::Weights | Self::Weight(_))
    }
}

/// The interpolation between two keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight; rotations along the shorter arc.
    #[default]
    Linear,
    /// The value of the key before.
    Step,
    /// Hermite splines.
    CubicSpline,
}

impl Interpolation {
    /// Number of values for each key: three with tangents, else one.
    #[must_use]
    pub fn values_per_key(self) -> usize {
        if self == Self::CubicSpline { 3 } else { 1 }
    }
}

impl Animation {
    /// The time of the last key in seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.channels.iter().filter_map(|c| c.times.last()).fold(0.0, |a, &b| a.max(b))
    }

    /// Returns the pose at a moment: the rest pose with the animated properties replaced. Before
    /// its first key a property has the value of that key, after its last key the value of the
    /// last. A node whose transform is a matrix keeps it (3.11: it must not be animated).
    #[must_use]
    pub fn pose(&self, graph: &Graph, seconds: f64) -> Pose {
        let mut pose = graph.rest_pose();
        for channel in &self.channels {
            channel.apply(&mut pose, seconds);
        }
        pose
    }
}

impl Channel {
    fn apply(&self, pose: &mut Pose, seconds: f64) {
        let node = self.node as usize;
        if self.property.is_of_targets() {
            let Some((weights, value)) = pose.weights.get_mut(node).zip(self.at(seconds)) else {
                return;
            };
            match self.property {
                Property::Weight(target) => {
                    let target = target as usize;
                    weights.resize(weights.len().max(target + 1), 0.0);
                    weights[target..].iter_mut().zip(value).for_each(|(weight, v)| *weight = v);
                }
                _ => *weights = value,
            }
        } else if let Some(local) = pose.locals.get_mut(node) {
            self.apply_to(local, seconds);
        }
    }

    /// Changes the transform of its node to that of a moment.
    pub(crate) fn apply_to(&self, local: &mut LocalTransform, seconds: f64) {
        let LocalTransform::Trs { translation, rotation, scale } = local else { return };
        let Some(value) = self.at(seconds) else { return };
        let part: &mut [f64] = match self.property {
            Property::Translation => translation,
            Property::Rotation => rotation,
            Property::Scale => scale,
            Property::Weights | Property::Weight(_) => return,
        };
        part.iter_mut().zip(value).for_each(|(component, v)| *component = v);
    }

    /// Returns the value at a moment; none without keys.
    #[must_use]
    pub fn at(&self, seconds: f64) -> Option<Vec<f64>> {
        let next = self.times.partition_point(|&t| t <= seconds);
        let (first, last) = (0, self.times.len().checked_sub(1)?);
        if next == 0 || next > last {
            return Some(self.value(if next == 0 { first } else { last }).to_vec());
        }
        let (previous, span) = (next - 1, self.times[next] - self.times[next - 1]);
        let t = (seconds - self.times[previous]) / span;
        Some(match self.interpolation {
            Interpolation::Step => self.value(previous).to_vec(),
            Interpolation::Linear if self.property == Property::Rotation => {
                slerp(self.value(previous), self.value(next), t)
            }
            Interpolation::Linear => {
                let ends = self.value(previous).iter().zip(self.value(next));
                ends.map(|(a, b)| a + t * (b - a)).collect()
            }
            Interpolation::CubicSpline => self.spline(previous, t, span),
        })
    }

    /// Number of components of one value.
    fn components(&self) -> usize {
        self.values.len() / (self.times.len() * self.interpolation.values_per_key()).max(1)
    }

    /// Value number `i` of a key; of three the incoming tangent, the value and the outgoing
    /// tangent.
    fn key_value(&self, key: usize, i: usize) -> &[f64] {
        let per_key = self.interpolation.values_per_key();
        &self.values[(key * per_key + i) * self.components()..][..self.components()]
    }

    fn value(&self, key: usize) -> &[f64] {
        self.key_value(key, self.interpolation.values_per_key() / 2)
    }

    fn spline(&self, previous: usize, t: f64, span: f64) -> Vec<f64> {
        let (t2, t3) = (t * t, t * t * t);
        let (a, b) = (self.value(previous), self.value(previous + 1));
        let (outgoing, incoming) = (self.key_value(previous, 2), self.key_value(previous + 1, 0));
        let at = |i: usize| {
            (2.0 * t3 - 3.0 * t2 + 1.0) * a[i]
                + span * (t3 - 2.0 * t2 + t) * outgoing[i]
                + (3.0 * t2 - 2.0 * t3) * b[i]
                + span * (t3 - t2) * incoming[i]
        };
        (0..self.components()).map(at).collect()
    }
}

/// Terms of the series in [`sine_ratio`]. Each is at most half the one before, so 60 are enough for
/// double precision.
const SINE_RATIO_TERMS: u32 = 60;

/// Interpolates between two quaternions on the shorter arc. They may have any length; if one is
/// zero, the nearer one is returned.
fn slerp(a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
    let length = |q: &[f64]| q.iter().map(|c| c * c).sum::<f64>().sqrt();
    let (la, lb) = (length(a), length(b));
    if la == 0.0 || lb == 0.0 {
        return if t < 0.5 { a.to_vec() } else { b.to_vec() };
    }
    let cosine = a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>() / (la * lb);
    let sign = if cosine < 0.0 { -1.0 } else { 1.0 };
    let cosine = cosine.abs().min(1.0);
    let (from, to) = (sine_ratio(1.0 - t, cosine) / la, sign * sine_ratio(t, cosine) / lb);
    a.iter().zip(b).map(|(x, y)| from * x + to * y).collect()
}

/// Returns sin(tφ) / sin φ for t from 0 to 1 and a cosine of φ from 0 to 1, by a series in the
/// cosine (Eberly, "A Fast and Accurate Algorithm for Computing SLERP"): the same on every machine.
fn sine_ratio(t: f64, cosine: f64) -> f64 {
    let mut term = t;
    let mut sum = t;
    for i in 1..=SINE_RATIO_TERMS {
        let i = f64::from(i);
        term *= (t * t - i * i) / (i * (2.0 * i + 1.0)) * (cosine - 1.0);
        sum += term;
    }
    sum
}

#[cfg(test)]
#[path = "animation_tests.rs"]
mod tests;
