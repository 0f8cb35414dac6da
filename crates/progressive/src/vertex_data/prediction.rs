//! Prediction of a new vertex's position and attributes from the vertices around it: weighted
//! means, linear fits, directions.
//!
//! All of it is arithmetic in double precision, in the order written, without fused operations:
//! both sides of a stream must find the same numbers (docs/STREAM.md, section 6).

use crate::vertex_data::number_system::{NumberSystem, round};
use crate::vertex_data::octahedral::Octahedral;
use crate::vertex_data::vertex_layout::{Prediction, Stream};
use crate::vertex_data::vertex_values::{Neighborhood, VertexValues};

/// The weight of the parent in the prediction of a position, against the mean of the link, and that
/// of the cut, the middle between the apexes of the two new triangles: a vertex lies outside its
/// link, away from the cut. Fitted on four meshes; half or twice as much cost 0.1 to 0.4 bits.
const PARENT_WEIGHT: f64 = 0.2;
const CUT_WEIGHT: f64 = 0.16;
/// Share of the mean distance that is added to a distance, so that no weight is infinite. A
/// contract of the format, like the others; chosen by hand.
const DISTANCE_SHARE: f64 = 0.05;
/// Share of their trace that is added to the diagonal of a fit's slopes: a ring is mostly flat, and
/// tells nothing about the slope across. Chosen by hand.
const RIDGE_SHARE: f64 = 0.02;

/// A predicted index, and the range of the indices around if it says how good the prediction is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Guess {
    pub(crate) index: i32,
    pub(crate) spread: Option<u32>,
}

/// The position that a vertex is expected at.
pub(crate) struct Position {
    /// The mean of the ring; without one the parent's position.
    pub(crate) mean: [i32; 3],
    /// The mean with weights for the parent and the cut.
    pub(crate) weighted: [i32; 3],
    /// The range of the ring, if it has more than one vertex.
    pub(crate) spread: [Option<u32>; 3],
    /// `weighted` before it is rounded, in indices.
    at: [f64; 3],
    /// If positions are in a system with a fixed step and there is a link: where one axis follows
    /// from the others.
    pub(crate) plane: Option<TangentPlane>,
}

/// The plane of the ring and the cut around a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TangentPlane {
    /// The axes in the order in which they are coded: that closest to the normal last.
    pub(crate) axes: [usize; 3],
    slopes: [f64; 2],
    /// Half the diagonal of the ring's box.
    pub(crate) spread: u32,
}

impl Position {
    /// Predicts a position: the parent's without a link.
    #[inline]
    pub(crate) fn predict(
        systems: &[NumberSystem],
        n: &Neighborhood<'_>,
        indices: impl Fn(u32) -> [i32; 3],
    ) -> Self {
        let [parent, left, right] = [n.parent, n.cut[0], n.cut[1]].map(&indices);
        let mut position = Self {
            mean: parent,
            weighted: parent,
            spread: [None; 3],
            at: parent.map(f64::from),
            plane: None,
        };
        if n.link.is_empty() {
            return position;
        }
        let (mut sums, mut least, mut most) = ([0i64; 3], [i32::MAX; 3], [i32::MIN; 3]);
        for &v in n.link {
            let neighbour = indices(v);
            for c in 0..3 {
                sums[c] += i64::from(neighbour[c]);
                (least[c], most[c]) = (least[c].min(neighbour[c]), most[c].max(neighbour[c]));
            }
        }
        let count = n.link.len() as f64;
        let mut means = [0.0; 3];
        for c in 0..3 {
            let [p, l, r] = [parent[c], left[c], right[c]];
            let even = systems[c]
                .is_evenly_spaced(least[c].min(p).min(l).min(r), most[c].max(p).max(l).max(r));
            let real = |i| if even { f64::from(i) } else { f64::from(systems[c].value(i)) };
            let sum = match even {
                true => sums[c] as f64,
                false => n.link.iter().fold(0.0, |sum, &v| sum + real(indices(v)[c])),
            };
            let mean = sum / count;
            let cut = (real(l) + real(r)) / 2.0;
            let at = mean + PARENT_WEIGHT * (real(p) - mean) - CUT_WEIGHT * (cut - mean);
            means[c] = mean;
            position.at[c] = at;
            position.mean[c] = nearest_index(systems[c], even, mean, p);
            position.weighted[c] = nearest_index(systems[c], even, at, p);
            position.spread[c] = (n.link.len() > 1).then(|| most[c].abs_diff(least[c]));
        }
        if systems[0].has_fixed_step() && n.link.len() > 1 {
            let edge = [0, 1, 2].map(|c| f64::from(left[c]) - f64::from(right[c]));
            let outwards = [0, 1, 2].map(|c| means[c] - f64::from(parent[c]));
            let box_ = [0, 1, 2].map(|c| f64::from(most[c].abs_diff(least[c])));
            position.plane = Some(TangentPlane::new(edge, outwards, box_));
        }
        position
    }
}

impl TangentPlane {
    /// The plane of two vectors, in a box with these sides.
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
        let off = |axis: usize| f64::from(coded[axis]) - position.at[axis];
        round(position.at[last] + self.slopes[0] * off(first) + self.slopes[1] * off(second))
    }
}

/// Predicts the values of a vertex from those around it, once its position is known.
pub(crate) struct ValuePredictor<'a> {
    pub(crate) values: &'a VertexValues,
    pub(crate) neighborhood: &'a Neighborhood<'a>,
    /// The indices of the vertex that are known, those of its position first.
    pub(crate) position: &'a [i32],
}

impl ValuePredictor<'_> {
    fn index(&self, vertex: u32, channel: usize) -> i32 {
        self.values.indices[vertex as usize * self.values.channels() + channel]
    }

    /// Predicts the channels of a stream.
    pub(crate) fn predict(&self, stream: &Stream) -> Vec<Guess> {
        let link = self.neighborhood.link;
        let channels = stream.first..stream.first + stream.channels;
        if stream.prediction == Prediction::Parent || link.is_empty() {
            let parent = |c| Guess { index: self.index(self.neighborhood.parent, c), spread: None };
            return channels.map(parent).collect();
        }
        match stream.prediction {
            Prediction::Fit => {
                let weights = Fit::new(&self.offsets());
                channels.map(|c| self.fitted(c, &weights)).collect()
            }
            Prediction::Octahedral(octahedral) => self.direction(stream, octahedral),
            _ => channels.map(|c| self.fitted(c, &Fit::Mean)).collect(),
        }
    }

    /// The offsets of the link from the vertex, in indices or, if these have no fixed step, in
    /// values.
    fn offsets(&self) -> Vec<[f64; 3]> {
        let systems = &self.values.layout.systems;
        let real = |c: usize, i: i32| {
            if systems[0].has_fixed_step() { f64::from(i) } else { f64::from(systems[c].value(i)) }
        };
        let own = [0, 1, 2].map(|c| real(c, self.position[c]));
        let offset = |&v: &u32| [0, 1, 2].map(|c| real(c, self.index(v, c)) - own[c]);
        self.neighborhood.link.iter().map(offset).collect()
    }

    /// Predicts a channel as a weighted mean over the link.
    fn fitted(&self, channel: usize, fit: &Fit) -> Guess {
        let (link, system) = (self.neighborhood.link, self.values.layout.systems[channel]);
        let indices = || link.iter().map(|&v| self.index(v, channel));
        let least = indices().min().unwrap_or_default();
        let most = indices().max().unwrap_or_default();
        let even = system.is_evenly_spaced(least, most);
        let real = |i| if even { f64::from(i) } else { f64::from(system.value(i)) };
        let reals: Vec<f64> = indices().map(real).collect();
        let at = fit.at_vertex(&reals);
        let parent = self.index(self.neighborhood.parent, channel);
        let index = nearest_index(system, even, at, parent);
        Guess { index, spread: (link.len() > 1).then(|| most.abs_diff(least)) }
    }

    /// Predicts the two numbers of a direction; what follows them is the mean.
    fn direction(&self, stream: &Stream, octahedral: Octahedral) -> Vec<Guess> {
        let fit = Fit::distances(&self.offsets());
        let mut sum = [0.0; 3];
        for (i, &v) in self.neighborhood.link.iter().enumerate() {
            let at = [self.index(v, stream.first), self.index(v, stream.first + 1)];
            let direction = octahedral.direction(at);
            let weight = fit.get(i).copied().unwrap_or_default();
            for c in 0..3 {
                sum[c] += weight * direction[c];
            }
        }
        let channels = stream.first..stream.first + stream.channels;
        let mut guesses: Vec<Guess> = channels.map(|c| self.fitted(c, &Fit::Mean)).collect();
        for (guess, index) in guesses.iter_mut().zip(octahedral.indices(sum)) {
            guess.index = index;
        }
        guesses
    }
}

/// The weights of vertices around one.
enum Fit {
    /// All alike.
    Mean,
    /// These, by their distances.
    Weighted(Vec<f64>),
    /// The value at the vertex of a function that is linear in space, fitted to those around.
    Affine { weights: Vec<f64>, offsets: Vec<[f64; 3]> },
}

impl Fit {
    /// Fits a linear function if there are four vertices for its four numbers.
    fn new(offsets: &[[f64; 3]]) -> Self {
        let weights = Self::distances(offsets);
        if offsets.len() < 4 {
            return Self::Weighted(weights);
        }
        Self::Affine { weights, offsets: offsets.to_vec() }
    }

    /// Weights that fall with the distance.
    fn distances(offsets: &[[f64; 3]]) -> Vec<f64> {
        let lengths: Vec<f64> =
            offsets.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt()).collect();
        let mean = lengths.iter().fold(0.0, |sum, d| sum + d) / lengths.len() as f64;
        let weight = |d: &f64| if mean > 0.0 { 1.0 / (d + DISTANCE_SHARE * mean) } else { 1.0 };
        lengths.iter().map(weight).collect()
    }

    /// The value at the vertex, given those around.
    fn at_vertex(&self, values: &[f64]) -> f64 {
        match self {
            Self::Mean => values.iter().fold(0.0, |sum, v| sum + v) / values.len() as f64,
            Self::Weighted(weights) => weighted_mean(weights, values),
            Self::Affine { weights, offsets } => {
                // Normal equations of value = a + b x + c y + d z, weighted twice by nearness; a
                // row for each of a, b, c, d, and what it equals last.
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

fn weighted_mean(weights: &[f64], values: &[f64]) -> f64 {
    let pairs = || weights.iter().zip(values);
    pairs().fold(0.0, |sum, (w, v)| sum + w * v) / weights.iter().fold(0.0, |sum, w| sum + w)
}

/// Solves four symmetric equations, of which the upper triangles are given, for the first unknown.
/// `None` if they are singular.
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

/// Returns the index nearest to a number that is itself an index if `even`, else a value; `parent`
/// if it is not finite as a float.
#[inline]
pub(crate) fn nearest_index(system: NumberSystem, even: bool, at: f64, parent: i32) -> i32 {
    if even {
        return round(at);
    }
    let value = at as f32;
    if value.is_finite() { system.index(value) } else { parent }
}
