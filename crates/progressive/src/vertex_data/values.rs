//! Coding of a new vertex's values, stream by stream (position, then each attribute): either the
//! number of a nearby vertex with the same value, or residuals to a prediction.
//!
//! A slot is an entry of a table of contexts; a sibling is another wedge of the vertex's group.

use crate::entropy::adaptive_probability::AdaptiveSymbol;
use crate::entropy::coder::Coder;
use crate::entropy::integer_codes::{ResidualCode, bit_length};
use crate::vertex_data::number_system::NumberSystem;
use crate::vertex_data::prediction::{Guess, Position, Scale, ValuePredictor};
use crate::vertex_data::vertex_layout::{AttributeStream, Prediction};
use crate::vertex_data::vertex_values::{Neighbourhood, VertexValues};

/// Streams with contexts of their own; all further ones share those of stream 0. Nearly all meshes
/// have fewer.
const STREAM_SLOTS: usize = 8;
/// The slot of positions that are predicted with a plane.
const PLANE_SLOT: usize = STREAM_SLOTS;
/// Channels of a stream with contexts of their own; further ones share the last.
const CHANNEL_SLOTS: usize = 4;
/// Classes of how well the channel before was predicted. Six gain nothing over three.
const ACCURACIES: usize = 3;
/// The most vertices of each kind among which a value is looked for: not more than a symbol can
/// name.
const MAX_CANDIDATES: usize = 15;
/// [`ValueContexts::source`] has this index for a vertex's first attribute.
const NO_PREVIOUS_SOURCE: usize = 4;

/// Where the value of an attribute comes from; the numbers are those of the symbols.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ValueSource {
    /// It is that of a sibling.
    Sibling = 0,
    /// It is that of the parent.
    Parent = 1,
    /// It is that of a vertex in the link.
    Link = 2,
    /// Residuals follow.
    Coded = 3,
}

/// How a position is predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PositionMode {
    /// As the mean of the link.
    Mean,
    /// As that mean, moved towards the parent and away from the cut.
    Weighted,
    /// Like `Weighted`, with the last axis from a plane.
    Plane,
}

/// Contexts of values.
#[derive(Clone, Debug)]
pub(crate) struct ValueContexts {
    /// The source of an attribute: by stream; whether there are siblings (1) and link vertices (2)
    /// to take it from; the source of the stream's last vertex; that of the stream before (4:
    /// none).
    pub(crate) source: [[[[AdaptiveSymbol; 5]; 4]; 4]; STREAM_SLOTS],
    /// Which sibling (0) or link vertex (1): by that, and their number less one, up to 7.
    pub(crate) which: [[AdaptiveSymbol; 8]; 2],
    /// The source of each stream at the last vertex.
    last_source: [usize; STREAM_SLOTS],
    /// By stream and channel; how well the channel before was predicted (0 best); the second
    /// highest bit of the expected magnitude.
    pub(crate) residual: [[[ResidualCode; 2]; ACCURACIES]; (STREAM_SLOTS + 1) * CHANNEL_SLOTS],
    /// Sixteen times the mean bit length of the residuals of a stream and channel.
    mean_bits: [u32; (STREAM_SLOTS + 1) * CHANNEL_SLOTS],
    /// 64 times the mean bit length of the residuals of a position in each [`PositionMode`].
    mode_bits: [u32; 3],
}

impl ValueContexts {
    pub(crate) fn new() -> Self {
        Self {
            source: [[[[AdaptiveSymbol::NEW; 5]; 4]; 4]; STREAM_SLOTS],
            which: [[AdaptiveSymbol::NEW; 8]; 2],
            last_source: [ValueSource::Coded as usize; STREAM_SLOTS],
            residual: [[[ResidualCode::NEW; 2]; ACCURACIES]; (STREAM_SLOTS + 1) * CHANNEL_SLOTS],
            // Residuals are expected to have 16 bits at first, positions three of them.
            mean_bits: [16 * 16; (STREAM_SLOTS + 1) * CHANNEL_SLOTS],
            mode_bits: [64 * 48; 3],
        }
    }

    /// Codes the index `wanted` (which a decoder does not know and passes as 0), given its
    /// prediction; returns it. Its residual is expected to have as many bits as the spread of the
    /// indices around or, if that is not known, as earlier residuals of the slot.
    ///
    /// `accuracy` says how well the channel before was predicted, from 0 (best) to
    /// [`ACCURACIES`] − 1, and then how well this one was: errors of channels go together.
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

/// Returns the bit below the highest one: in which half of the numbers of its length `spread` is.
fn second_bit(spread: u32) -> usize {
    let bits = bit_length(spread);
    if bits < 2 { 0 } else { (spread >> (bits - 2)) as usize & 1 }
}

impl VertexValues {
    /// Codes the values of a vertex into `coded`: an index for each channel, those of its position
    /// first. `wanted` has the same for an encoder and nothing for a decoder.
    pub(crate) fn code<C: Coder>(
        &self,
        coder: &mut C,
        contexts: &mut ValueContexts,
        neighbourhood: &Neighbourhood<'_>,
        wanted: &[i32],
        coded: &mut Vec<i32>,
    ) {
        coded.clear();
        let mut vertex = VertexCode {
            values: self,
            neighbourhood,
            sibling: None,
            previous_source: NO_PREVIOUS_SOURCE,
            candidates: Vec::new(),
        };
        if let Some(wedge) = neighbourhood.siblings.clone().next_back() {
            coded.extend(self.stream_indices(wedge, &self.layout.streams[0]));
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
    neighbourhood: &'a Neighbourhood<'a>,
    /// The sibling whose value the stream before had.
    sibling: Option<u32>,
    /// The source of the stream before, or [`NO_PREVIOUS_SOURCE`].
    previous_source: usize,
    /// Vertices with different values in the present stream: siblings, the parent, the link.
    candidates: Vec<u32>,
}

impl VertexCode<'_> {
    /// Codes the position of a vertex without siblings.
    fn code_position<C: Coder>(
        &self,
        coder: &mut C,
        contexts: &mut ValueContexts,
        wanted: &[i32],
    ) -> [i32; 3] {
        let values = self.values;
        let wanted = |axis: usize| wanted.get(axis).copied().unwrap_or_default();
        let position = Position::predict(&values.layout.systems, self.neighbourhood, |v| {
            let start = v as usize * values.channels();
            values.indices[start..].first_chunk().copied().unwrap_or_default()
        });
        let (mut coded, mut accuracy) = ([0; 3], 0);
        match (contexts.mode(), position.plane) {
            (PositionMode::Plane, Some(plane)) => {
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
                    let is_mean = mode == PositionMode::Mean;
                    let index = if is_mean { position.mean } else { position.weighted }[axis];
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

    /// Codes the attribute of stream `s` and appends its channels.
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
        let slot = stream_slot(s);
        let wanted = wanted.get(stream.first_channel..).unwrap_or_default();
        let wanted = &wanted[..stream.channels.min(wanted.len())];
        let [siblings_end, parent_end] = self.find_candidates(stream);
        let has_link_candidate = parent_end < self.candidates.len();
        let available = usize::from(siblings_end > 0) + 2 * usize::from(has_link_candidate);
        let has_value = |&v: &u32| values.stream_indices(v, stream) == wanted;
        let found = self.candidates.iter().position(has_value);
        let source = match found {
            Some(number) if number < siblings_end => ValueSource::Sibling,
            Some(number) if number < parent_end => ValueSource::Parent,
            Some(_) => ValueSource::Link,
            None => ValueSource::Coded,
        };
        let last = contexts.last_source[slot];
        let context = &mut contexts.source[slot][available][last][self.previous_source];
        let source = coder.symbol(context, source as u32).min(3) as usize;
        (contexts.last_source[slot], self.previous_source) = (source, source);
        let range = match source {
            0 => 0..siblings_end,
            1 => siblings_end..parent_end,
            2 => parent_end..self.candidates.len(),
            _ => 0..0,
        };
        if range.is_empty() {
            // The source is `Coded`, or one without candidates, as only a crafted stream names it.
            let predictor =
                ValuePredictor { values, neighbourhood: self.neighbourhood, position: coded };
            let guesses = predictor.predict(stream);
            self.code_residuals(coder, contexts, s, &guesses, wanted, coded);
            return;
        }
        let mut offset = 0;
        if range.len() > 1 {
            let is_link = source == ValueSource::Link as usize;
            let context = &mut contexts.which[usize::from(is_link)][(range.len() - 1).min(7)];
            let which = found.unwrap_or_default().wrapping_sub(range.start) as u32;
            offset = (coder.symbol(context, which) as usize).min(range.len() - 1);
        }
        let vertex = self.candidates[range.start + offset];
        if source == ValueSource::Sibling as usize {
            self.sibling = Some(vertex);
        }
        coded.extend_from_slice(values.stream_indices(vertex, stream));
    }

    /// Collects `candidates`. Returns where the siblings and the parent end in it.
    fn find_candidates(&mut self, stream: &AttributeStream) -> [usize; 2] {
        self.candidates.clear();
        let latest = self.neighbourhood.siblings.clone().rev().take(MAX_CANDIDATES);
        for v in self.sibling.into_iter().chain(latest) {
            if self.candidates.len() < MAX_CANDIDATES {
                self.add_candidate(v, stream);
            }
        }
        let siblings_end = self.candidates.len();
        self.add_candidate(self.neighbourhood.parent, stream);
        let parent_end = self.candidates.len();
        for &v in self.neighbourhood.link.iter().take(MAX_CANDIDATES) {
            self.add_candidate(v, stream);
        }
        [siblings_end, parent_end]
    }

    /// Appends a vertex to `candidates` if no other there has its value.
    fn add_candidate(&mut self, v: u32, stream: &AttributeStream) {
        let value = self.values.stream_indices(v, stream);
        if self.candidates.iter().all(|&c| self.values.stream_indices(c, stream) != value) {
            self.candidates.push(v);
        }
    }

    /// Codes the channels of stream `s` as residuals to `guesses`, and appends them.
    fn code_residuals<C: Coder>(
        &self,
        coder: &mut C,
        contexts: &mut ValueContexts,
        s: usize,
        guesses: &[Guess],
        wanted: &[i32],
        coded: &mut Vec<i32>,
    ) {
        let stream = &self.values.layout.streams[s];
        let systems = &self.values.layout.systems[stream.first_channel..];
        let is_direction =
            stream.prediction == Prediction::Direction && !self.neighbourhood.link.is_empty();
        let mut accuracy = 0;
        for (channel, &guess) in guesses.iter().enumerate() {
            let slot = stream_slot(s) * CHANNEL_SLOTS + channel.min(CHANNEL_SLOTS - 1);
            let mut guess = guess;
            if is_direction && channel == 2 {
                let x = f64::from(systems[0].value(coded[stream.first_channel]));
                let y = f64::from(systems[1].value(coded[stream.first_channel + 1]));
                guess = third_component(systems[2], [x, y], guess);
            }
            let wanted = wanted.get(channel).copied().unwrap_or_default();
            coded.push(contexts.code(coder, slot, &mut accuracy, guess, wanted));
        }
    }
}

/// Returns the slot of stream `s`.
fn stream_slot(s: usize) -> usize {
    if s < STREAM_SLOTS { s } else { 0 }
}

impl ValueContexts {
    /// Returns the mode in which positions were predicted best so far, the last of equals.
    fn mode(&self) -> PositionMode {
        let [mean, weighted, plane] = self.mode_bits;
        if plane <= mean.min(weighted) {
            PositionMode::Plane
        } else if weighted <= mean {
            PositionMode::Weighted
        } else {
            PositionMode::Mean
        }
    }

    /// Updates the mean length of residuals in each mode, as if the position had been predicted in
    /// it.
    fn update_mode(&mut self, position: &Position, coded: &[i32; 3]) {
        let bits = |guess: &[i32; 3]| -> u32 {
            (0..3).map(|c| bit_length(coded[c].abs_diff(guess[c]))).sum()
        };
        let mut on_plane = position.weighted;
        if let Some(plane) = position.plane {
            on_plane[plane.axes[2]] = plane.guess(position, coded);
        }
        let guesses = [&position.mean, &position.weighted, &on_plane];
        for (mean, guess) in self.mode_bits.iter_mut().zip(guesses) {
            *mean = (*mean * 63 + bits(guess) * 64 + 32) / 64;
        }
    }
}

/// Predicts the third component of a unit vector from the first two, with the sign of `guess`;
/// returns `guess` if those are longer than 1.
fn third_component(system: NumberSystem, [x, y]: [f64; 2], guess: Guess) -> Guess {
    let square = 1.0 - x * x - y * y;
    if square < 0.0 || square.is_nan() {
        return guess;
    }
    let root = square.sqrt();
    let signed = if system.value(guess.index) < 0.0 { -root } else { root };
    let index = Scale::Values.nearest_index(system, signed, guess.index);
    Guess { index, spread: None }
}
