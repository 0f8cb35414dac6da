//! Coding of a new vertex's values, stream by stream: either the number of a nearby vertex with the
//! same value, or residuals to a prediction.

use crate::entropy::adaptive_probability::AdaptiveSymbol;
use crate::entropy::coder::Coder;
use crate::entropy::integer_codes::{ResidualCode, bit_length};
use crate::vertex_data::number_system::NumberSystem;
use crate::vertex_data::prediction::{Guess, Position, ValuePredictor, nearest_index};
use crate::vertex_data::vertex_layout::{Prediction, Stream};
use crate::vertex_data::vertex_values::{Neighborhood, VertexValues};

/// Streams with contexts of their own; all further ones share those of stream 0. More than nearly
/// any mesh has.
const STREAM_SLOTS: usize = 8;
/// The slot of positions of which the last channel follows from a plane.
const PLANE_SLOT: usize = STREAM_SLOTS;
/// Channels of a stream with contexts of their own; further ones share the last.
const CHANNEL_SLOTS: usize = 4;
/// Classes of how well the channel before was predicted. Six gain nothing over three.
const ACCURACIES: usize = 3;
/// The most vertices among whose values a value is looked for: those that a symbol can name.
const MAX_SOURCES: usize = 15;

/// The source of an attribute: how it is coded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    /// It is that of another wedge of the group.
    Mate = 0,
    /// It is that of the parent.
    Parent = 1,
    /// It is that of a vertex in the link.
    Link = 2,
    /// Residuals follow.
    Coded = 3,
}

/// Contexts of values.
#[derive(Clone, Debug)]
pub(crate) struct ValueContexts {
    /// The source of an attribute: by stream; whether there are mates (1) and link vertices (2) to
    /// take it from; the source of the stream's last vertex; that of the stream before (4: none).
    pub(crate) source: [[[[AdaptiveSymbol; 5]; 4]; 4]; STREAM_SLOTS],
    /// Which mate or link vertex: by its kind, and their number less one, up to 7.
    pub(crate) which: [[AdaptiveSymbol; 8]; 2],
    last_source: [usize; STREAM_SLOTS],
    /// By stream and channel, how well the channel before was predicted, and the second bit of the
    /// expected magnitude.
    pub(crate) residual: [[[ResidualCode; 2]; ACCURACIES]; (STREAM_SLOTS + 1) * CHANNEL_SLOTS],
    /// Sixteen times the mean bit length of the residuals of a stream and channel.
    mean_bits: [u32; (STREAM_SLOTS + 1) * CHANNEL_SLOTS],
    /// 64 times the mean bit length of the residuals of a position in each of the three ways.
    mode_bits: [u32; 3],
}

impl ValueContexts {
    pub(crate) fn new() -> Self {
        Self {
            source: [[[[AdaptiveSymbol::NEW; 5]; 4]; 4]; STREAM_SLOTS],
            which: [[AdaptiveSymbol::NEW; 8]; 2],
            last_source: [Source::Coded as usize; STREAM_SLOTS],
            residual: [[[ResidualCode::NEW; 2]; ACCURACIES]; (STREAM_SLOTS + 1) * CHANNEL_SLOTS],
            mean_bits: [16 * 16; (STREAM_SLOTS + 1) * CHANNEL_SLOTS],
            mode_bits: [64 * 48; 3],
        }
    }

    /// Codes an index whose prediction is known. `spread` is the range of those around; without
    /// it the mean length of the residuals before is expected.
    #[inline]
    fn code<C: Coder>(
        &mut self,
        coder: &mut C,
        slot: usize,
        accuracy: &mut usize,
        guess: Guess,
        wanted: i32,
    ) -> i32 {
        let (expected, half) = match guess.spread {
            Some(spread) => (bit_length(spread), second_bit(spread)),
            None => ((self.mean_bits[slot] + 8) / 16, 0),
        };
        let residual = i64::from(wanted) - i64::from(guess.index);
        let context = &mut self.residual[slot][*accuracy][half];
        let residual = context.code(coder, expected.min(32), residual);
        self.mean_bits[slot] = (self.mean_bits[slot] * 15 + residual.bits * 16 + 8) / 16;
        *accuracy = match residual.bits + 2 {
            bits if bits < expected => 0,
            bits if bits < expected + 2 => 1,
            _ => 2,
        };
        // Wraps only in a stream that no encoder writes.
        (i64::from(guess.index) + residual.value) as i32
    }
}

/// The bit below the highest one.
fn second_bit(spread: u32) -> usize {
    let bits = bit_length(spread);
    if bits < 2 { 0 } else { (spread >> (bits - 2)) as usize & 1 }
}

impl VertexValues {
    /// Codes the values of a vertex into `coded`. `wanted` has all its channels for an encoder and
    /// none for a decoder.
    pub(crate) fn code<C: Coder>(
        &self,
        coder: &mut C,
        contexts: &mut ValueContexts,
        neighborhood: &Neighborhood<'_>,
        wanted: &[i32],
        coded: &mut Vec<i32>,
    ) {
        coded.clear();
        let mut vertex = VertexCode {
            values: self,
            neighborhood,
            mate: None,
            previous_source: 4,
            sources: Vec::new(),
        };
        if let Some(wedge) = neighborhood.mates.clone().next_back() {
            coded.extend(self.of(wedge, &self.layout.streams[0]));
        } else {
            let position = vertex.code_position(coder, contexts, wanted);
            coded.extend(position);
        }
        for s in 1..self.layout.streams.len() {
            vertex.code_attribute(coder, contexts, s, wanted, coded);
        }
    }
}

/// The values of one vertex while they are coded.
struct VertexCode<'a> {
    values: &'a VertexValues,
    neighborhood: &'a Neighborhood<'a>,
    /// The mate whose value the stream before had.
    mate: Option<u32>,
    /// The source of the stream before; 4 for none.
    previous_source: usize,
    sources: Vec<u32>,
}

impl VertexCode<'_> {
    fn code_position<C: Coder>(
        &self,
        coder: &mut C,
        contexts: &mut ValueContexts,
        wanted: &[i32],
    ) -> [i32; 3] {
        let (values, n) = (self.values, self.neighborhood);
        let wanted = |axis: usize| wanted.get(axis).copied().unwrap_or_default();
        let position = Position::predict(&values.layout.systems, n, |v| {
            let at = v as usize * values.channels();
            values.indices[at..].first_chunk().copied().unwrap_or_default()
        });
        let (mut coded, mut accuracy) = ([0; 3], 0);
        match (contexts.mode(), position.plane) {
            (2, Some(plane)) => {
                let slot = PLANE_SLOT * CHANNEL_SLOTS;
                for (channel, axis) in plane.axes.into_iter().enumerate() {
                    let index = match channel {
                        2 => plane.guess(&position, &coded),
                        _ => position.weighted[axis],
                    };
                    let guess = Guess { index, spread: Some(plane.spread) };
                    let slot = slot + channel;
                    coded[axis] = contexts.code(coder, slot, &mut accuracy, guess, wanted(axis));
                }
            }
            (mode, _) => {
                for (axis, coded) in coded.iter_mut().enumerate() {
                    let index = if mode == 0 { position.mean } else { position.weighted }[axis];
                    let guess = Guess { index, spread: position.spread[axis] };
                    *coded = contexts.code(coder, axis, &mut accuracy, guess, wanted(axis));
                }
            }
        }
        if position.spread[0].is_some() {
            contexts.update_mode(&position, &coded);
        }
        coded
    }

    /// Codes an attribute and appends its channels.
    fn code_attribute<C: Coder>(
        &mut self,
        coder: &mut C,
        contexts: &mut ValueContexts,
        s: usize,
        wanted: &[i32],
        coded: &mut Vec<i32>,
    ) {
        let values = self.values;
        let stream = &values.layout.streams[s];
        let slot = if s < STREAM_SLOTS { s } else { 0 };
        let wanted = wanted.get(stream.first..).unwrap_or_default();
        let wanted = &wanted[..stream.channels.min(wanted.len())];
        let [mates, parents] = self.find_sources(stream);
        let available = usize::from(mates > 0) + 2 * usize::from(parents < self.sources.len());
        let found = self.sources.iter().position(|&v| values.of(v, stream) == wanted);
        let source = match found {
            Some(offset) if offset < mates => Source::Mate,
            Some(offset) if offset < parents => Source::Parent,
            Some(_) => Source::Link,
            None => Source::Coded,
        };
        let last = contexts.last_source[slot];
        let context = &mut contexts.source[slot][available][last][self.previous_source];
        let source = coder.symbol(context, source as u32).min(3) as usize;
        (contexts.last_source[slot], self.previous_source) = (source, source);
        let range = match source {
            0 => 0..mates,
            1 => mates..parents,
            2 => parents..self.sources.len(),
            _ => 0..0,
        };
        if range.is_empty() {
            // Also a source that only a crafted stream names.
            let predictor =
                ValuePredictor { values, neighborhood: self.neighborhood, position: coded };
            let guesses = predictor.predict(stream);
            self.code_residuals(coder, contexts, [s, slot], &guesses, wanted, coded);
            return;
        }
        let mut offset = 0;
        if range.len() > 1 {
            let context = &mut contexts.which[source >> 1][(range.len() - 1).min(7)];
            let which = found.unwrap_or_default().wrapping_sub(range.start) as u32;
            offset = (coder.symbol(context, which) as usize).min(range.len() - 1);
        }
        let vertex = self.sources[range.start + offset];
        self.mate = if source == 0 { Some(vertex) } else { self.mate };
        coded.extend_from_slice(values.of(vertex, stream));
    }

    /// Collects vertices with different values: mates, the parent, the link. Returns where the
    /// first two end.
    fn find_sources(&mut self, stream: &Stream) -> [usize; 2] {
        let (values, n) = (self.values, self.neighborhood);
        let sources = &mut self.sources;
        sources.clear();
        let mut add = |v: u32, max_count: usize| {
            let is_new = sources.len() < max_count
                && sources.iter().all(|&s| values.of(s, stream) != values.of(v, stream));
            if is_new {
                sources.push(v);
            }
            sources.len()
        };
        let mut ends = [0; 2];
        let latest = n.mates.clone().rev().take(MAX_SOURCES);
        for v in self.mate.into_iter().chain(latest) {
            ends[0] = add(v, MAX_SOURCES);
        }
        ends[1] = add(n.parent, MAX_SOURCES + 1);
        for &v in n.link.iter().take(MAX_SOURCES) {
            add(v, usize::MAX);
        }
        ends
    }

    fn code_residuals<C: Coder>(
        &self,
        coder: &mut C,
        contexts: &mut ValueContexts,
        [s, slot]: [usize; 2],
        guesses: &[Guess],
        wanted: &[i32],
        coded: &mut Vec<i32>,
    ) {
        let stream = &self.values.layout.streams[s];
        let systems = &self.values.layout.systems[stream.first..];
        let is_direction =
            stream.prediction == Prediction::Direction && !self.neighborhood.link.is_empty();
        let mut accuracy = 0;
        for (channel, &guess) in guesses.iter().enumerate() {
            let slot = slot * CHANNEL_SLOTS + channel.min(CHANNEL_SLOTS - 1);
            let mut guess = guess;
            if is_direction && channel == 2 {
                let x = f64::from(systems[0].value(coded[stream.first]));
                let y = f64::from(systems[1].value(coded[stream.first + 1]));
                guess = third_component(systems[2], [x, y], guess);
            }
            let wanted = wanted.get(channel).copied().unwrap_or_default();
            coded.push(contexts.code(coder, slot, &mut accuracy, guess, wanted));
        }
    }
}

impl ValueContexts {
    /// The way in which positions were predicted best so far, the last of equals: 0 by the mean, 1
    /// by weights, 2 by weights and a plane.
    fn mode(&self) -> usize {
        let [mean, weighted, plane] = self.mode_bits;
        if plane <= mean.min(weighted) { 2 } else { usize::from(weighted <= mean) }
    }

    /// Notes how long the residuals are in each way.
    fn update_mode(&mut self, position: &Position, coded: &[i32; 3]) {
        let bits = |guess: &[i32; 3]| -> u32 {
            (0..3).map(|c| bit_length(coded[c].abs_diff(guess[c]))).sum()
        };
        let mut on_plane = position.weighted;
        if let Some(plane) = position.plane {
            on_plane[plane.axes[2]] = plane.guess(position, coded);
        }
        let ways = [&position.mean, &position.weighted, &on_plane];
        for (mean, way) in self.mode_bits.iter_mut().zip(ways) {
            *mean = (*mean * 63 + bits(way) * 64 + 32) / 64;
        }
    }
}

/// Predicts the third component of a unit vector with these first two, with the sign of `guess`,
/// unless they are too long.
fn third_component(system: NumberSystem, [x, y]: [f64; 2], guess: Guess) -> Guess {
    let square = 1.0 - x * x - y * y;
    if square < 0.0 || square.is_nan() {
        return guess;
    }
    let root = square.sqrt();
    let signed = if system.value(guess.index) < 0.0 { -root } else { root };
    Guess { index: nearest_index(system, false, signed, guess.index), spread: None }
}
