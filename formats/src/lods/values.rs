//! Positions and attributes of a new vertex, told as differences from what its neighbours suggest.

use super::coder::{Bit, Coder};
use super::growth::Growth;
use super::model::{Residual, bits};
use super::script::Script;

/// How the channels of a stream are predicted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Prediction {
    /// From the vertices around, smoothly.
    Smooth,
    /// The same, as a direction of length one: the third channel follows from the first two.
    Direction,
    /// The survivor's.
    Survivor,
}

/// A stream: some channels that belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stream {
    pub(super) first: usize,
    pub(super) channels: usize,
    pub(super) prediction: Prediction,
}

/// Streams share models beyond this many, and channels of one stream beyond this many.
const STREAMS: usize = 8;
const CHANNELS: usize = 4;

/// What is known about values.
#[derive(Clone, Debug)]
pub(super) struct ValueModels {
    /// By stream: the survivor's values again; and whether that was so before.
    again: [[Bit; 2]; STREAMS],
    was_again: [usize; STREAMS],
    /// By stream, channel and how well the channel before it was predicted.
    residual: Vec<[Residual; 3]>,
    /// Sixteen times the usual bits, for channels without neighbours to tell.
    usual: [u32; STREAMS * CHANNELS],
}

impl ValueModels {
    pub(super) fn new() -> Self {
        let residual = vec![[const { Residual::NEW }; 3]; STREAMS * CHANNELS];
        Self {
            again: [[Bit::NEW; 2]; STREAMS],
            was_again: [0; STREAMS],
            residual,
            usual: [16 * 16; STREAMS * CHANNELS],
        }
    }
}

/// What is told about a new vertex besides its numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near<'a> {
    pub(super) survivor: u32,
    /// A vertex of the same step that has the same position.
    pub(super) mate: Option<u32>,
    /// The vertices around the new one.
    pub(super) rim: &'a [u32],
}

impl Growth {
    /// Says the values of the vertex that was added last, and adds them. `found` is a buffer.
    pub(super) fn values<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut ValueModels,
        streams: &[Stream],
        near: Near<'_>,
        found: &mut Vec<i32>,
    ) {
        let new = self.vertices() - 1;
        let truth = if C::WRITES { script.index(new) } else { &[] };
        found.clear();
        for (s, stream) in streams.iter().enumerate() {
            let copied = match (s, near.mate) {
                (0, Some(mate)) => Some(mate),
                _ => None,
            };
            let own = |v: u32| {
                let own = &self.numbers[v as usize * self.channels() + stream.first..][..stream.channels];
                own.iter().map(|n| n.0)
            };
            let wanted = if C::WRITES { &truth[stream.first..][..stream.channels] } else { &[] };
            if let Some(mate) = copied {
                found.extend(own(mate));
                continue;
            }
            let set = s.min(STREAMS) % STREAMS;
            if s > 0 {
                let was = models.was_again[set];
                let is = coder.bit(&mut models.again[set][was], wanted.iter().copied().eq(own(near.survivor)));
                models.was_again[set] = usize::from(is);
                if is {
                    found.extend(own(near.survivor));
                    continue;
                }
            }
            self.stream(coder, models, set, stream, near, wanted, found);
        }
        self.add_values(found);
    }

    #[expect(clippy::too_many_arguments, reason = "it is the inner part of the one caller above")]
    fn stream<C: Coder>(
        &self,
        coder: &mut C,
        models: &mut ValueModels,
        set: usize,
        stream: &Stream,
        near: Near<'_>,
        wanted: &[i32],
        found: &mut Vec<i32>,
    ) {
        let all = self.channels();
        let survivor = near.survivor as usize * all + stream.first;
        let smooth = stream.prediction != Prediction::Survivor && !near.rim.is_empty();
        let mut quality = 0;
        // The first two channels of a direction, once they are known.
        let mut length = [0.0f64; 2];
        for channel in 0..stream.channels {
            let slot = set * CHANNELS + channel.min(CHANNELS - 1);
            let system = self.systems[stream.first + channel];
            let (mut guess, mut expected) = (self.numbers[survivor + channel].1, (models.usual[slot] + 8) / 16);
            let mut exact = None;
            let mut lean = 0;
            if smooth {
                let (mut sum, mut least, mut most) = (0.0, i32::MAX, i32::MIN);
                for &v in near.rim {
                    let at = v as usize * all + stream.first + channel;
                    let (index, value) = self.numbers[at];
                    sum += f64::from(value);
                    (least, most) = (least.min(index), most.max(index));
                }
                let mean = (sum / near.rim.len() as f64) as f32;
                if mean.is_finite() {
                    lean = if mean > guess { 1 } else { 2 };
                    guess = mean;
                }
                if near.rim.len() > 1 {
                    expected = bits(most.abs_diff(least));
                }
                if stream.prediction == Prediction::Direction && channel == 2 {
                    let square = 1.0 - length[0] * length[0] - length[1] * length[1];
                    if square >= 0.0 {
                        let root = square.sqrt() as f32;
                        guess = if guess < 0.0 { -root } else { root };
                        expected = (models.usual[slot] + 8) / 16;
                    }
                }
            } else {
                exact = Some(self.numbers[survivor + channel].0);
            }
            let guess = exact.unwrap_or_else(|| system.index(guess));
            let truth = wanted.get(channel).copied().unwrap_or_default();
            let difference = i64::from(truth) - i64::from(guess);
            let (difference, class) = models.residual[slot][quality].code(coder, expected.min(32), lean, difference);
            models.usual[slot] = (models.usual[slot] * 15 + class * 16 + 8) / 16;
            quality = match class + 2 {
                c if c < expected => 0,
                c if c < expected + 2 => 1,
                _ => 2,
            };
            // What no writer says wraps.
            let index = (i64::from(guess) + difference) as i32;
            if let Some(l) = length.get_mut(channel) {
                *l = f64::from(system.value(index));
            }
            found.push(index);
        }
    }
}
