//! Positions and attributes of a new vertex, told as differences from what its neighbours suggest.

use super::chances::Bit;
use super::coder::Coder;
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
    residual: [[Residual; 3]; STREAMS * CHANNELS],
    /// Sixteen times the usual bits, for channels without neighbours to tell.
    usual: [u32; STREAMS * CHANNELS],
}

impl ValueModels {
    pub(super) fn new() -> Self {
        Self {
            again: [[Bit::NEW; 2]; STREAMS],
            was_again: [0; STREAMS],
            residual: [[Residual::NEW; 3]; STREAMS * CHANNELS],
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
                self.numbers[v as usize * self.channels() + stream.first..][..stream.channels]
                    .iter()
                    .copied()
            };
            let wanted = if C::WRITES { &truth[stream.first..][..stream.channels] } else { &[] };
            if let Some(mate) = copied {
                found.extend(own(mate));
                continue;
            }
            let set = s.min(STREAMS) % STREAMS;
            if s > 0 {
                let was = models.was_again[set];
                let is = coder.bit(
                    &mut models.again[set][was],
                    wanted.iter().copied().eq(own(near.survivor)),
                );
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
        let smooth = stream.prediction != Prediction::Survivor && !near.rim.is_empty();
        let mut quality = 0;
        // The first two channels of a direction, once they are known.
        let mut length = [0.0f64; 2];
        let mut guesses = [Guess::default(); CHANNELS];
        for channel in 0..stream.channels {
            let slot = set * CHANNELS + channel.min(CHANNELS - 1);
            let at = stream.first + channel;
            if channel % CHANNELS == 0 {
                self.guesses(
                    near,
                    at,
                    smooth,
                    &mut guesses[..(stream.channels - channel).min(CHANNELS)],
                );
            }
            let Guess { number: mut guess, bits: expected } = guesses[channel % CHANNELS];
            let usual = (models.usual[slot] + 8) / 16;
            let mut expected = if smooth && near.rim.len() > 1 { expected } else { usual };
            if smooth && stream.prediction == Prediction::Direction && channel == 2 {
                let square = 1.0 - length[0] * length[0] - length[1] * length[1];
                if square >= 0.0 {
                    let root = square.sqrt() as f32;
                    let system = self.systems[at];
                    guess = system.index(if system.value(guess) < 0.0 { -root } else { root });
                    expected = usual;
                }
            }
            let truth = wanted.get(channel).copied().unwrap_or_default();
            let difference = i64::from(truth) - i64::from(guess);
            let (difference, class) =
                models.residual[slot][quality].code(coder, expected.min(32), difference);
            models.usual[slot] = (models.usual[slot] * 15 + class * 16 + 8) / 16;
            quality = match class + 2 {
                c if c < expected => 0,
                c if c < expected + 2 => 1,
                _ => 2,
            };
            // What no writer says wraps.
            let index = (i64::from(guess) + difference) as i32;
            if stream.prediction == Prediction::Direction
                && let Some(l) = length.get_mut(channel)
            {
                *l = f64::from(self.systems[at].value(index));
            }
            found.push(index);
        }
    }

    /// What the vertices around suggest for some channels, from number `first` on; or the
    /// survivor's numbers.
    #[inline]
    fn guesses(&self, near: Near<'_>, first: usize, smooth: bool, guesses: &mut [Guess]) {
        let own =
            &self.numbers[near.survivor as usize * self.channels() + first..][..guesses.len()];
        for (guess, &own) in guesses.iter_mut().zip(own) {
            *guess = Guess { number: own, bits: 0 };
        }
        match guesses.len() {
            _ if !smooth => {}
            1 => self.means::<1>(near, first, guesses),
            2 => self.means::<2>(near, first, guesses),
            3 => self.means::<3>(near, first, guesses),
            _ => self.means::<4>(near, first, guesses),
        }
    }

    #[inline]
    fn means<const N: usize>(&self, near: Near<'_>, first: usize, guesses: &mut [Guess]) {
        let all = self.channels();
        let at = |v: u32| v as usize * all + first;
        let (mut sum, mut least, mut most) = ([0i64; N], [i32::MAX; N], [i32::MIN; N]);
        for &v in near.rim {
            let Some(numbers) = self.numbers[at(v)..].first_chunk::<N>() else { continue };
            for i in 0..N {
                sum[i] += i64::from(numbers[i]);
                (least[i], most[i]) = (least[i].min(numbers[i]), most[i].max(numbers[i]));
            }
        }
        for (i, guess) in guesses.iter_mut().enumerate().take(N) {
            guess.bits = bits(most[i].abs_diff(least[i]));
            let system = self.systems[first + i];
            if system.is_even(least[i], most[i]) {
                guess.number = mean(sum[i], near.rim.len(), guess.number);
            } else {
                let floats =
                    near.rim.iter().map(|&v| f64::from(system.value(self.numbers[at(v) + i])));
                let mean = (floats.sum::<f64>() / near.rim.len() as f64) as f32;
                if mean.is_finite() {
                    guess.number = system.index(mean);
                }
            }
        }
    }
}

/// What is expected of a channel.
#[derive(Clone, Copy, Debug, Default)]
struct Guess {
    number: i32,
    /// Of how many bits the difference is.
    bits: u32,
}

/// 2^24 / n, rounded down.
const SHARES: [i64; 33] = {
    let mut shares = [0; 33];
    let mut n = 1;
    while n < shares.len() {
        shares[n] = (1 << 24) / n as i64;
        n += 1;
    }
    shares
};

/// The mean of `count` numbers with this sum, seen from one in their midst.
#[inline]
fn mean(sum: i64, count: usize, own: i32) -> i32 {
    let far = sum - count as i64 * i64::from(own);
    let far = match SHARES.get(count) {
        Some(share) => far.wrapping_mul(*share).wrapping_add(1 << 23) >> 24,
        None => far / count as i64,
    };
    (i64::from(own) + far).clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}
