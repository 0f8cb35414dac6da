//! Coding of a new vertex's values, as residuals to a prediction from its neighbours.

use crate::entropy::adaptive_probability::AdaptiveBit;
use crate::entropy::coder::Coder;
use crate::entropy::integer_codes::{ResidualCode, bit_length};
use crate::vertex_data::number_system::NumberSystem;
use crate::vertex_data::vertex_layout::{Prediction, Stream, VertexLayout};

/// Streams with contexts of their own; all further ones share those of stream 0.
const STREAM_SLOTS: usize = 8;
/// Channels of a stream with contexts of their own; further ones share the last.
const CHANNEL_SLOTS: usize = 4;

/// Contexts of values.
#[derive(Clone, Debug)]
pub(crate) struct ValueContexts {
    /// By stream, and whether the stream's previous vertex repeated its parent: it repeats the
    /// parent's value.
    pub(crate) repeats: [[AdaptiveBit; 2]; STREAM_SLOTS],
    previous_repeats: [bool; STREAM_SLOTS],
    /// By stream and channel, and how well the channel before was predicted.
    pub(crate) residual: [[ResidualCode; 3]; STREAM_SLOTS * CHANNEL_SLOTS],
    /// Sixteen times the mean bit length of the residuals of a stream and channel.
    mean_bits: [u32; STREAM_SLOTS * CHANNEL_SLOTS],
}

impl ValueContexts {
    pub(crate) fn new() -> Self {
        Self {
            repeats: [[AdaptiveBit::NEW; 2]; STREAM_SLOTS],
            previous_repeats: [false; STREAM_SLOTS],
            residual: [[ResidualCode::NEW; 3]; STREAM_SLOTS * CHANNEL_SLOTS],
            mean_bits: [16 * 16; STREAM_SLOTS * CHANNEL_SLOTS],
        }
    }
}

/// The vertices from which the values of a new one are predicted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Neighborhood<'a> {
    pub(crate) parent: u32,
    /// A vertex of the same step at the same position.
    pub(crate) wedge: Option<u32>,
    /// The vertices around the new one.
    pub(crate) link: &'a [u32],
}

/// The values of all vertices so far.
#[derive(Clone, Debug)]
pub(crate) struct VertexValues {
    pub(crate) layout: VertexLayout,
    /// The channels of each vertex as indices of their number systems.
    pub(crate) indices: Vec<i32>,
}

/// A predicted index and an estimate of the residual.
#[derive(Clone, Copy, Debug, Default)]
struct Predicted {
    index: i32,
    /// Bit length of the spread of the indices around.
    spread_bits: u32,
}

impl VertexValues {
    pub(crate) fn new(layout: VertexLayout) -> Self {
        Self { layout, indices: Vec::new() }
    }

    pub(crate) fn channels(&self) -> usize {
        self.layout.systems.len()
    }

    /// Codes the values of a vertex into `coded`. `wanted` has all its channels for an encoder and
    /// none for a decoder.
    pub(crate) fn code<C: Coder>(
        &self,
        coder: &mut C,
        contexts: &mut ValueContexts,
        neighborhood: Neighborhood<'_>,
        wanted: &[i32],
        coded: &mut Vec<i32>,
    ) {
        coded.clear();
        for (s, stream) in self.layout.streams.iter().enumerate() {
            let of = |v: u32| {
                self.indices[v as usize * self.channels() + stream.first..][..stream.channels]
                    .iter()
                    .copied()
            };
            let wanted = wanted.get(stream.first..).unwrap_or_default();
            let wanted = &wanted[..stream.channels.min(wanted.len())];
            if let (0, Some(wedge)) = (s, neighborhood.wedge) {
                coded.extend(of(wedge));
                continue;
            }
            let slot = if s < STREAM_SLOTS { s } else { 0 };
            if s > 0 {
                let context =
                    &mut contexts.repeats[slot][usize::from(contexts.previous_repeats[slot])];
                let repeats = wanted.iter().copied().eq(of(neighborhood.parent));
                let repeats = coder.bit(context, repeats);
                contexts.previous_repeats[slot] = repeats;
                if repeats {
                    coded.extend(of(neighborhood.parent));
                    continue;
                }
            }
            let stream = StreamCoding { values: self, stream, slot, neighborhood };
            stream.code(coder, contexts, wanted, coded);
        }
    }
}

/// One stream of a new vertex.
struct StreamCoding<'a> {
    values: &'a VertexValues,
    stream: &'a Stream,
    slot: usize,
    neighborhood: Neighborhood<'a>,
}

impl StreamCoding<'_> {
    /// Codes the channels and appends them to `coded`.
    fn code<C: Coder>(
        &self,
        coder: &mut C,
        contexts: &mut ValueContexts,
        wanted: &[i32],
        coded: &mut Vec<i32>,
    ) {
        let stream = self.stream;
        let link = self.neighborhood.link;
        let smooth = stream.prediction != Prediction::Parent && !link.is_empty();
        let direction = smooth && stream.prediction == Prediction::Direction;
        let mut accuracy = 0;
        let mut direction_xy = [0.0f64; 2];
        let mut predicted = [Predicted::default(); CHANNEL_SLOTS];
        for channel in 0..stream.channels {
            let slot = self.slot * CHANNEL_SLOTS + channel.min(CHANNEL_SLOTS - 1);
            if channel % CHANNEL_SLOTS == 0 {
                let batch = (stream.channels - channel).min(CHANNEL_SLOTS);
                self.predict(stream.first + channel, smooth, &mut predicted[..batch]);
            }
            let Predicted { index: mut guess, spread_bits } = predicted[channel % CHANNEL_SLOTS];
            let mean_bits = (contexts.mean_bits[slot] + 8) / 16;
            let mut expected = if smooth && link.len() > 1 { spread_bits } else { mean_bits };
            if direction
                && channel == 2
                && let Some(index) = self.third_component(direction_xy, guess)
            {
                (guess, expected) = (index, mean_bits);
            }
            let wanted = wanted.get(channel).copied().unwrap_or_default();
            let residual = i64::from(wanted) - i64::from(guess);
            let context = &mut contexts.residual[slot][accuracy];
            let residual = context.code(coder, expected.min(32), residual);
            contexts.mean_bits[slot] =
                (contexts.mean_bits[slot] * 15 + residual.bits * 16 + 8) / 16;
            accuracy = match residual.bits + 2 {
                bits if bits < expected => 0,
                bits if bits < expected + 2 => 1,
                _ => 2,
            };
            // Wraps only in a stream that no encoder writes.
            let index = (i64::from(guess) + residual.value) as i32;
            if direction && let Some(component) = direction_xy.get_mut(channel) {
                let system = self.values.layout.systems[stream.first + channel];
                *component = f64::from(system.value(index));
            }
            coded.push(index);
        }
    }

    /// Returns the index of the third component of a unit vector with these first two, with the
    /// sign of `guess`; `None` if they are too long.
    fn third_component(&self, [x, y]: [f64; 2], guess: i32) -> Option<i32> {
        let square = 1.0 - x * x - y * y;
        if square < 0.0 || square.is_nan() {
            return None;
        }
        let root = square.sqrt() as f32;
        let system = self.values.layout.systems[self.stream.first + 2];
        Some(system.index(if system.value(guess) < 0.0 { -root } else { root }))
    }

    /// Predicts some channels from number `first` on: by the mean over the link if `smooth`, else
    /// by the parent.
    #[inline]
    fn predict(&self, first: usize, smooth: bool, predicted: &mut [Predicted]) {
        let parent = self.neighborhood.parent as usize * self.values.channels() + first;
        let parent = &self.values.indices[parent..][..predicted.len()];
        for (predicted, &index) in predicted.iter_mut().zip(parent) {
            *predicted = Predicted { index, spread_bits: 0 };
        }
        match predicted.len() {
            _ if !smooth => {}
            1 => self.link_means::<1>(first, predicted),
            2 => self.link_means::<2>(first, predicted),
            3 => self.link_means::<3>(first, predicted),
            _ => self.link_means::<4>(first, predicted),
        }
    }

    #[inline]
    fn link_means<const N: usize>(&self, first: usize, predicted: &mut [Predicted]) {
        let (values, link) = (self.values, self.neighborhood.link);
        let channels = values.channels();
        let at = |v: u32| v as usize * channels + first;
        let (mut sum, mut least, mut most) = ([0i64; N], [i32::MAX; N], [i32::MIN; N]);
        for &v in link {
            let Some(indices) = values.indices[at(v)..].first_chunk::<N>() else { continue };
            for i in 0..N {
                sum[i] += i64::from(indices[i]);
                (least[i], most[i]) = (least[i].min(indices[i]), most[i].max(indices[i]));
            }
        }
        for (i, predicted) in predicted.iter_mut().enumerate().take(N) {
            predicted.spread_bits = bit_length(most[i].abs_diff(least[i]));
            let system = values.layout.systems[first + i];
            if system.is_evenly_spaced(least[i], most[i]) {
                predicted.index = mean_index(sum[i], link.len(), predicted.index);
            } else {
                let floats = link.iter().map(|&v| values.indices[at(v) + i]);
                predicted.index = mean_value(system, floats).unwrap_or(predicted.index);
            }
        }
    }
}

/// Returns the index of the mean of floats, which are added in their order; `None` if it is not
/// finite.
#[inline]
fn mean_value(system: NumberSystem, indices: impl ExactSizeIterator<Item = i32>) -> Option<i32> {
    let count = indices.len() as f64;
    let mean = (indices.map(|i| f64::from(system.value(i))).sum::<f64>() / count) as f32;
    mean.is_finite().then(|| system.index(mean))
}

/// 2^24 / n, rounded down: division by small numbers.
const RECIPROCALS: [i64; 33] = {
    let mut reciprocals = [0; 33];
    let mut n = 1;
    while n < reciprocals.len() {
        reciprocals[n] = (1 << 24) / n as i64;
        n += 1;
    }
    reciprocals
};

/// Returns the mean of `count` indices with this sum, rounded relative to the parent's index.
#[inline]
fn mean_index(sum: i64, count: usize, parent: i32) -> i32 {
    let offset = sum - count as i64 * i64::from(parent);
    let offset = match RECIPROCALS.get(count) {
        Some(reciprocal) => offset.wrapping_mul(*reciprocal).wrapping_add(1 << 23) >> 24,
        None => offset / count as i64,
    };
    (i64::from(parent) + offset).clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}
