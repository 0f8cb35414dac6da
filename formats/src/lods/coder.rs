//! An adaptive entropy coder: the same model code writes and reads.
//!
//! Everything a stream says is said through [`Coder`]. A writer passes the truth and gets it back;
//! a reader passes anything and gets what was written. So the code that models a stream exists once
//! and the two sides cannot differ. What has chances is coded by asymmetric numeral systems (Duda
//! 2013, in the range variant), from the front of a run; what has none stands as plain bits, from
//! its end.

use super::chances::{Bit, SCALE, Symbol, WHOLE};

/// The least state: below it a reader takes two more bytes.
const LEAST: u64 = 1 << 23;
/// Bytes of a state.
const STATE: usize = 5;

/// Says bits, or hears them.
pub(super) trait Coder {
    /// Whether this is the side that knows.
    const WRITES: bool;
    /// A bit whose chances `model` knows.
    fn bit(&mut self, model: &mut Bit, bit: bool) -> bool;
    /// A number below 16 whose chances `model` knows.
    fn symbol(&mut self, model: &mut Symbol, value: u32) -> u32;
    /// Up to 32 bits without a model.
    fn raw(&mut self, bits: u32, value: u32) -> u32;

    /// A number below `end`, all equally likely. `end` is at least 1.
    #[inline]
    fn uniform(&mut self, end: u32, value: u32) -> u32 {
        let bits = end.ilog2();
        let short = if bits == 31 { u32::MAX - end + 1 } else { (2u32 << bits) - end };
        // The first `short` numbers take one bit less than the others.
        let (high, last) = if value < short {
            (value, 0)
        } else {
            (value.wrapping_add(short) >> 1, value.wrapping_add(short) & 1)
        };
        let high = self.raw(bits, high);
        if high < short { high } else { (high << 1 | self.raw(1, last)).wrapping_sub(short) }
    }
}

/// The two runs of a block: its mesh, and where the triangles stand in strips.
#[derive(Debug, Default)]
pub(super) struct Runs<C> {
    pub(super) mesh: C,
    pub(super) strips: C,
}

/// The side that knows: makes bytes.
#[derive(Debug, Default)]
pub(super) struct Encoder {
    /// Begin and chance of all that was said by models. A reader hears last what is coded first.
    parts: Vec<(u16, u16)>,
    /// About how many 256th of bits these take.
    cost: u64,
    /// Bits without models, the first being the lowest of the first.
    bits: Vec<u8>,
    open: u64,
    open_bits: u32,
}

impl Encoder {
    /// About how many bytes there are so far.
    pub(super) fn len(&self) -> usize {
        (self.cost >> 11) as usize + self.bits.len() + STATE
    }

    /// All bytes: the front with what was said by models, the back with the bits without.
    pub(super) fn finish(mut self) -> Run {
        let mut state = LEAST;
        let mut words: Vec<u16> = Vec::new();
        for &(start, chance) in self.parts.iter().rev() {
            let chance = u64::from(chance);
            if state >= chance << (39 - SCALE) {
                words.push(state as u16);
                state >>= 16;
            }
            state = (state / chance) << SCALE | (state % chance + u64::from(start));
        }
        let mut front = state.to_le_bytes()[..STATE].to_vec();
        front.extend(words.iter().rev().flat_map(|w| w.to_le_bytes()));
        if self.parts.is_empty() && self.bits.is_empty() && self.open_bits == 0 {
            front.clear();
        }
        let open = self.open.to_le_bytes();
        self.bits.extend_from_slice(&open[..self.open_bits.div_ceil(8) as usize]);
        self.bits.reverse();
        Run { front, back: self.bits }
    }

    #[inline]
    fn part(&mut self, start: u16, chance: u16) {
        self.parts.push((start, chance));
        // The logarithm, with a straight line between powers of two.
        let log = chance.ilog2();
        let part = (u32::from(chance) << (SCALE - log) & u32::from(WHOLE - 1)) >> (SCALE - 8);
        self.cost += u64::from(((SCALE - log) << 8) - part);
    }
}

/// What an [`Encoder`] made. Anything may stand between the two ends.
#[derive(Clone, Debug, Default)]
pub(super) struct Run {
    pub(super) front: Vec<u8>,
    pub(super) back: Vec<u8>,
}

impl Run {
    /// The bytes, with so many of nothing in the middle.
    pub(super) fn bytes(mut self, padding: usize) -> Vec<u8> {
        self.front.resize(self.front.len() + padding, 0);
        self.front.append(&mut self.back);
        self.front
    }

    pub(super) fn len(&self) -> usize {
        self.front.len() + self.back.len()
    }
}

impl Coder for Encoder {
    const WRITES: bool = true;

    #[inline]
    fn bit(&mut self, model: &mut Bit, bit: bool) -> bool {
        let set = model.set();
        let (start, chance) = if bit { (0, set) } else { (set, WHOLE - set) };
        self.part(start, chance);
        model.learn(bit);
        bit
    }

    #[inline]
    fn symbol(&mut self, model: &mut Symbol, value: u32) -> u32 {
        let symbol = value as usize & 15;
        let (start, chance) = model.part(symbol);
        self.part(start, chance);
        model.learn(symbol);
        value
    }

    #[inline]
    fn raw(&mut self, bits: u32, value: u32) -> u32 {
        self.open |= u64::from(value) << self.open_bits;
        self.open_bits += bits;
        if self.open_bits >= 32 {
            self.bits.extend_from_slice(&(self.open as u32).to_le_bytes());
            self.open >>= 32;
            self.open_bits -= 32;
        }
        value
    }
}

/// The side that hears: reads bytes, and zeros behind them.
#[derive(Debug)]
pub(super) struct Decoder<'a> {
    state: u64,
    bytes: &'a [u8],
    /// Bytes taken from the front.
    front: usize,
    /// Bytes taken from the end, and their bits that were not asked for yet.
    back: usize,
    open: u64,
    open_bits: u32,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let mut new = Self { state: LEAST, bytes, front: 0, back: 0, open: 0, open_bits: 0 };
        if let Some(state) = bytes.get(..STATE) {
            new.state = state.iter().rev().fold(0, |all, &byte| all << 8 | u64::from(byte));
            new.front = STATE;
        }
        new
    }

    /// Whether it has taken more than there is: what it hears then was never said.
    pub(super) fn is_lost(&self) -> bool {
        self.front + self.back > self.bytes.len() + self.open_bits as usize / 8
    }

    /// Whether all that was said by models was heard, and nothing else.
    pub(super) fn is_done(&self) -> bool {
        self.state == LEAST && !self.is_lost()
    }

    #[inline]
    fn advance(&mut self, start: u16, chance: u16, slot: u16) {
        self.state =
            u64::from(chance) * (self.state >> SCALE) + u64::from(slot.wrapping_sub(start));
        if self.state < LEAST {
            let two = self
                .bytes
                .get(self.front..)
                .and_then(<[u8]>::first_chunk)
                .copied()
                .unwrap_or_default();
            self.state = self.state << 16 | u64::from(u16::from_le_bytes(two));
            self.front += 2;
        }
    }

    fn slot(&self) -> u16 {
        self.state as u16 & (WHOLE - 1)
    }

    /// Takes four bytes from the end.
    #[inline]
    fn fill(&mut self) {
        let end = self.bytes.len().saturating_sub(self.back);
        let four = match self.bytes[..end].last_chunk() {
            Some(four) => *four,
            None => std::array::from_fn(|i| if i + end >= 4 { self.bytes[i + end - 4] } else { 0 }),
        };
        self.open |= u64::from(u32::from_be_bytes(four)) << self.open_bits;
        self.open_bits += 32;
        self.back += 4;
    }
}

impl Coder for Decoder<'_> {
    const WRITES: bool = false;

    #[inline]
    fn bit(&mut self, model: &mut Bit, _: bool) -> bool {
        let (slot, set) = (self.slot(), model.set());
        let bit = slot < set;
        let (start, chance) = if bit { (0, set) } else { (set, WHOLE - set) };
        self.advance(start, chance, slot);
        model.learn(bit);
        bit
    }

    #[inline(always)]
    fn symbol(&mut self, model: &mut Symbol, _: u32) -> u32 {
        let slot = self.slot();
        let symbol = model.at(slot);
        let (start, chance) = model.part(symbol);
        self.advance(start, chance, slot);
        model.learn(symbol);
        symbol as u32
    }

    #[inline]
    fn raw(&mut self, bits: u32, _: u32) -> u32 {
        if self.open_bits < bits {
            self.fill();
        }
        let value = self.open & ((1 << bits) - 1);
        self.open >>= bits;
        self.open_bits -= bits;
        value as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    fn say<C: Coder>(coder: &mut C, random: &mut Random) -> Vec<u32> {
        // A reader does not know the truth.
        let wrong = !C::WRITES;
        let mut models = [Bit::NEW; 4];
        let mut symbols = [Symbol::NEW; 4];
        let mut said = Vec::new();
        for i in 0..20_000 {
            let skew = [2, 10, 1000, 100_000][i % 4];
            said.push(u32::from(coder.bit(&mut models[i % 4], (random.below(skew) == 0) ^ wrong)));
            let symbol =
                random.below([1, 2, 9, 16][i % 4] + usize::from(i % 1000 == 3)) as u32 & 15;
            said.push(coder.symbol(&mut symbols[i % 4], if wrong { 0 } else { symbol }));
            let bits = random.below(33) as u32;
            let end = (1 + random.next() % u64::from(u32::MAX >> random.below(32))) as u32;
            let value = (random.next() & ((1u64 << bits) - 1)) as u32;
            said.push(coder.raw(bits, if wrong { 0 } else { value }));
            let below = (random.next() % u64::from(end)) as u32;
            said.push(coder.uniform(end, if wrong { 0 } else { below }));
        }
        said
    }

    #[test]
    fn what_is_said_is_heard() {
        for seed in 0..20 {
            let mut encoder = Encoder::default();
            let said = say(&mut encoder, &mut Random(seed));
            let about = encoder.len();
            let run = encoder.finish();
            assert!(run.len().abs_diff(about) < about / 50, "{} bytes, not {about}", run.len());
            let bytes = run.bytes(seed as usize);
            let mut decoder = Decoder::new(&bytes);
            assert!(!decoder.is_done(), "seed {seed}");
            let mut random = Random(seed);
            assert_eq!(say(&mut decoder, &mut random), said, "seed {seed}");
            assert!(decoder.is_done(), "seed {seed}");
            let mut decoder = Decoder::new(&bytes[..bytes.len() / 2]);
            say(&mut decoder, &mut Random(seed));
            assert!(!decoder.is_done(), "seed {seed}");
        }
    }

    #[test]
    fn likely_things_take_little_room() {
        let mut encoder = Encoder::default();
        let (mut bit, mut symbol) = (Bit::NEW, Symbol::NEW);
        for _ in 0..40_000 {
            encoder.bit(&mut bit, true);
            encoder.symbol(&mut symbol, 7);
        }
        let bytes = encoder.finish().len();
        assert!(bytes < 200, "{bytes} bytes");
        assert_eq!(Encoder::default().finish().len(), 0);
    }
}
