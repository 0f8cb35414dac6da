//! Prediction of a new vertex's position and attributes from the vertices around it: weighted
//! means, linear fits, directions.
//!
//! All of it is arithmetic in double precision, in the order written, without fused operations:
//! both sides of a stream must find the same numbers (docs/STREAM.md, section 6).

use crate::vertex_data::number_system::{NumberSystem, round_half_up};
use crate::vertex_data::octahedral::Octahedral;
use crate::vertex_data::vertex_layout::{AttributeStream, Prediction};
use crate::vertex_data::vertex_values::{Neighbourhood, VertexValues};

// All constants here are part of the format: decoders must use the same.

/// A position is predicted as the mean of the link, moved towards the parent by this share of the
/// distance between them. Fitted on four meshes, with [`CUT_WEIGHT`]; half or twice as much cost
/// 0.1 to 0.4 bits.
const PARENT_WEIGHT: f64 = 0.2;
/// Likewise, the share by which it is moved away from the cut, the midpoint between the apexes of
/// the two new triangles: a new vertex lies on the far side of its link.
const CUT_WEIGHT: f64 = 0.16;
/// Share of the mean distance that is added to each distance, so that no weight is infinite. Chosen
/// by hand.
const DISTANCE_SHARE: f64 = 0.05;
/// Regularisation of linear fits: this share of the trace of the slopes' matrix is added to its
/// diagonal. The link is mostly flat and says nothing about the slope across it. Chosen by hand.
const RIDGE_SHARE: f64 = 0.02;

/// A predicted index.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Guess {
    pub(crate) index: i32,
    /// Largest minus least index of the vertices around, as a measure of the expected residual;
    /// none if it would say nothing.
    pub(crate) spread: Option<u32>,
}

/// What a mean is taken of: indices where the floats in question are evenly spaced, which is faster
/// and gives the same; else the floats themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    Indices,
    Values,
}

impl Scale {
    fn for_range(system: NumberSystem, lowest: i32, highest: i32) -> Self {
        if system.is_evenly_spaced(lowest, highest) { Self::Indices } else { Self::Values }
    }

    /// Returns an index as a number of this scale.
    fn number(self, system: NumberSystem, index: i32) -> f64 {
        match self {
            Self::Indices => f64::from(index),
            Self::Values => f64::from(system.value(index)),
        }
    }

    /// Returns the index nearest to a number of this scale; `parent` if the number is not finite as
    /// a float.
    #[inline]
    pub(crate) fn nearest_index(self, system: NumberSystem, number: f64, parent: i32) -> i32 {
        match self {
            Self::Indices => round_half_up(number),
            Self::Values => {
                let value = number as f32;
                if value.is_finite() { system.index(value) } else { parent }
            }
        }
    }
}

/// The position that a vertex is expected at.
pub(crate) struct Position {
    /// The mean of the link; without a link the parent's position.
    pub(crate) mean: [i32; 3],
    /// The mean with weights for the parent and the cut.
    pub(crate) weighted: [i32; 3],
    /// Largest minus least index of the link on each axis, if it has more than one vertex.
    pub(crate) spread: [Option<u32>; 3],
    /// `weighted` before it is rounded; on each axis an index or a value, see [`Scale`].
    weighted_unrounded: [f64; 3],
    /// Predicts the last axis from the other two, once they are coded. Only if positions are in a
    /// system with a fixed step and the link has more than one vertex.
    pub(crate) plane: Option<TangentPlane>,
}

/// The plane through the expected position that contains the edge between the two apexes and the
/// direction from the parent to the mean of the link.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TangentPlane {
    /// The axes in the order in which they are coded: that closest to the normal last.
    pub(crate) axes: [usize; 3],
    /// Change of the last axis for each unit of the first and of the second, −1 to 1: the last
    /// component of the normal is the largest. Both 0 if the plane is not defined.
    slopes: [f64; 2],
    /// Half the diagonal of the link's bounding box.
    pub(crate) spread: u32,
}

impl Position {
    /// Predicts a position; without a link it is the parent's. `systems` are those of the three
    /// axes, `indices` gives a vertex's position.
    #[inline]
    pub(crate) fn predict(
        systems: &[NumberSystem],
        neighbourhood: &Neighbourhood<'_>,
        indices: impl Fn(u32) -> [i32; 3],
    ) -> Self {
        let Neighbourhood { parent, apexes: [left, right], link, .. } = *neighbourhood;
        let [parent, left, right] = [parent, left, right].map(&indices);
        let mut position = Self {
            mean: parent,
            weighted: parent,
            spread: [None; 3],
            weighted_unrounded: parent.map(f64::from),
            plane: None,
        };
        if link.is_empty() {
            return position;
        }
        let (mut sums, mut lowest, mut highest) = ([0i64; 3], [i32::MAX; 3], [i32::MIN; 3]);
        for &v in link {
            let neighbour = indices(v);
            for c in 0..3 {
                sums[c] += i64::from(neighbour[c]);
                lowest[c] = lowest[c].min(neighbour[c]);
                highest[c] = highest[c].max(neighbour[c]);
            }
        }
        let count = link.len() as f64;
        let mut means = [0.0; 3];
        for c in 0..3 {
            let [p, l, r] = [parent[c], left[c], right[c]];
            let [lowest, highest] = [lowest[c], highest[c]];
            let system = systems[c];
            let scale =
                Scale::for_range(system, lowest.min(p).min(l).min(r), highest.max(p).max(l).max(r));
            let number = |index| scale.number(system, index);
            let sum = match scale {
                Scale::Indices => sums[c] as f64,
                Scale::Values => link.iter().fold(0.0, |sum, &v| sum + number(indices(v)[c])),
            };
            let mean = sum / count;
            let cut = (number(l) + number(r)) / 2.0;
            let weighted = mean + PARENT_WEIGHT * (number(p) - mean) - CUT_WEIGHT * (cut - mean);
            means[c] = mean;
            position.weighted_unrounded[c] = weighted;
            position.mean[c] = scale.nearest_index(system, mean, p);
            position.weighted[c] = scale.nearest_index(system, weighted, p);
            position.spread[c] = (link.len() > 1).then(|| highest.abs_diff(lowest));
        }
        if systems[0].has_fixed_step() && link.len() > 1 {
            let edge = [0, 1, 2].map(|c| f64::from(left[c]) - f64::from(right[c]));
            let outwards = [0, 1, 2].map(|c| means[c] - f64::from(parent[c]));
            let sides = [0, 1, 2].map(|c| f64::from(highest[c].abs_diff(lowest[c])));
            position.plane = Some(TangentPlane::new(edge, outwards, sides));
        }
        position
    }
}

impl TangentPlane {
    /// The plane of two vectors; the link's bounding box has these sides. All are in indices.
    fn new(edge: [f64; 3], outwards: [f64; 3], sides: [f64; 3]) -> Self {
        let cross = |i: usize, j: usize| edge[i] * outwards[j] - edge[j] * outwards[i];
        let normal = [cross(1, 2), cross(2, 0), cross(0, 1)];
        let size = normal.map(f64::abs);
        let mut last = 0;
        for axis in 1..3 {
            if size[axis] > size[last] {
                last = axis;
            }
        }
        let axes = [(last + 1) % 3, (last + 2) % 3, last];
        let slope = |axis: usize| {
            if size[last] > 0.0 { (-normal[axis] / normal[last]).clamp(-1.0, 1.0) } else { 0.0 }
        };
        let [x, y, z] = sides;
        let spread = ((x * x + y * y + z * z).sqrt() / 2.0) as u32;
        Self { axes, slopes: [slope(axes[0]), slope(axes[1])], spread }
    }

    /// Predicts the index on the last axis, given those on the others.
    pub(crate) fn guess(&self, position: &Position, coded: &[i32; 3]) -> i32 {
        let [first, second, last] = self.axes;
        let expected = position.weighted_unrounded;
        let offset = |axis: usize| f64::from(coded[axis]) - expected[axis];
        round_half_up(
            expected[last] + self.slopes[0] * offset(first) + self.slopes[1] * offset(second),
        )
    }
}

/// Predicts the values of a vertex from those around it, once its position is known.
pub(crate) struct ValuePredictor<'a> {
    pub(crate) values: &'a VertexValues,
    pub(crate) neighbourhood: &'a Neighbourhood<'a>,
    /// The new vertex's position, as indices; what else of it is coded may follow.
    pub(crate) position: &'a [i32],
}

impl ValuePredictor<'_> {
    fn index(&self, vertex: u32, channel: usize) -> i32 {
        self.values.indices[vertex as usize * self.values.channels() + channel]
    }

    /// Predicts the channels of a stream: a guess for each.
    pub(crate) fn predict(&self, stream: &AttributeStream) -> Vec<Guess> {
        let link = self.neighbourhood.link;
        let channels = stream.first_channel..stream.first_channel + stream.channels;
        if stream.prediction == Prediction::Parent || link.is_empty() {
            let parent =
                |c| Guess { index: self.index(self.neighbourhood.parent, c), spread: None };
            return channels.map(parent).collect();
        }
        match stream.prediction {
            Prediction::Fit => {
                let fit = Fit::by_position(self.offsets());
                channels.map(|c| self.fitted(c, &fit)).collect()
            }
            Prediction::Octahedral(octahedral) => self.direction(stream, octahedral),
            _ => channels.map(|c| self.fitted(c, &Fit::Mean)).collect(),
        }
    }

    /// The offsets of the link from the vertex, in indices or, if these have no fixed step, in
    /// values.
    fn offsets(&self) -> Vec<[f64; 3]> {
        let systems = &self.values.layout.systems;
        let scale = if systems[0].has_fixed_step() { Scale::Indices } else { Scale::Values };
        let number = |c: usize, index: i32| scale.number(systems[c], index);
        let center = [0, 1, 2].map(|c| number(c, self.position[c]));
        let offset = |&v: &u32| [0, 1, 2].map(|c| number(c, self.index(v, c)) - center[c]);
        self.neighbourhood.link.iter().map(offset).collect()
    }

    /// Predicts a channel from its values at the link.
    fn fitted(&self, channel: usize, fit: &Fit) -> Guess {
        let (link, system) = (self.neighbourhood.link, self.values.layout.systems[channel]);
        let indices = || link.iter().map(|&v| self.index(v, channel));
        let lowest = indices().min().unwrap_or_default();
        let highest = indices().max().unwrap_or_default();
        let scale = Scale::for_range(system, lowest, highest);
        let numbers: Vec<f64> = indices().map(|index| scale.number(system, index)).collect();
        let parent = self.index(self.neighbourhood.parent, channel);
        let index = scale.nearest_index(system, fit.at_vertex(&numbers), parent);
        Guess { index, spread: (link.len() > 1).then(|| highest.abs_diff(lowest)) }
    }

    /// Predicts the two indices of a direction on an octahedron from the weighted mean of the
    /// link's directions; further channels are the mean.
    fn direction(&self, stream: &AttributeStream, octahedral: Octahedral) -> Vec<Guess> {
        let weights = distance_weights(&self.offsets());
        let mut sum = [0.0; 3];
        for (i, &v) in self.neighbourhood.link.iter().enumerate() {
            let at = [self.index(v, stream.first_channel), self.index(v, stream.first_channel + 1)];
            let direction = octahedral.direction(at);
            let weight = weights.get(i).copied().unwrap_or_default();
            for c in 0..3 {
                sum[c] += weight * direction[c];
            }
        }
        let channels = stream.first_channel..stream.first_channel + stream.channels;
        let mut guesses: Vec<Guess> = channels.map(|c| self.fitted(c, &Fit::Mean)).collect();
        for (guess, index) in guesses.iter_mut().zip(octahedral.indices(sum)) {
            guess.index = index;
        }
        guesses
    }
}

/// How the value at a vertex follows from those at the vertices around it.
enum Fit {
    /// Their mean.
    Mean,
    /// Their mean with these weights, which fall with the distance.
    Weighted(Vec<f64>),
    /// The value at the vertex of a linear function of the position, fitted to those around by
    /// least squares.
    Affine { weights: Vec<f64>, offsets: Vec<[f64; 3]> },
}

impl Fit {
    /// A linear function if there are enough vertices for its four coefficients; else weights.
    fn by_position(offsets: Vec<[f64; 3]>) -> Self {
        let weights = distance_weights(&offsets);
        if offsets.len() < 4 { Self::Weighted(weights) } else { Self::Affine { weights, offsets } }
    }

    /// Returns the value at the vertex, given those around.
    fn at_vertex(&self, values: &[f64]) -> f64 {
        match self {
            Self::Mean => values.iter().fold(0.0, |sum, v| sum + v) / values.len() as f64,
            Self::Weighted(weights) => weighted_mean(weights, values),
            Self::Affine { weights, offsets } => {
                // Normal equations of value = a + b x + c y + d z, with squared weights: a row for
                // each of a, b, c and d; the right side is the last column.
                let mut rows = [[0.0; 5]; 4];
                for ((w, &[x, y, z]), value) in weights.iter().zip(offsets).zip(values) {
                    let terms = [1.0, x, y, z, *value];
                    for i in 0..4 {
                        for j in i..5 {
                            rows[i][j] += w * w * terms[i] * terms[j];
                        }
                    }
                }
                let ridge = RIDGE_SHARE * (rows[1][1] + rows[2][2] + rows[3][3]);
                for (i, row) in rows.iter_mut().enumerate().skip(1) {
                    row[i] += ridge;
                }
                solve_first(rows).unwrap_or_else(|| weighted_mean(weights, values))
            }
        }
    }
}

/// Returns a weight for each offset, which falls with its length.
fn distance_weights(offsets: &[[f64; 3]]) -> Vec<f64> {
    let lengths: Vec<f64> =
        offsets.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt()).collect();
    let mean = lengths.iter().fold(0.0, |sum, d| sum + d) / lengths.len() as f64;
    let weight = |d: &f64| if mean > 0.0 { 1.0 / (d + DISTANCE_SHARE * mean) } else { 1.0 };
    lengths.iter().map(weight).collect()
}

/// Returns the mean of `values`; there is a weight for each.
fn weighted_mean(weights: &[f64], values: &[f64]) -> f64 {
    let pairs = || weights.iter().zip(values);
    pairs().fold(0.0, |sum, (w, v)| sum + w * v) / weights.iter().fold(0.0, |sum, w| sum + w)
}

/// Solves four equations with a symmetric matrix, of which only the upper triangle is read, for the
/// first unknown. `None` if they are singular.
fn solve_first(mut rows: [[f64; 5]; 4]) -> Option<f64> {
    for k in (1..4).rev() {
        let (pivot, column) = (rows[k], rows.map(|row| row[k]));
        if pivot[k] <= 0.0 || pivot[k].is_nan() {
            return None;
        }
        for i in 0..k {
            let factor = rows[i][k] / pivot[k];
            for (left, right) in rows[i][i..k].iter_mut().zip(&column[i..k]) {
                *left -= factor * right;
            }
            rows[i][4] -= factor * pivot[4];
        }
    }
    let first = rows[0][4] / rows[0][0];
    first.is_finite().then_some(first)
}
