//! An adaptive binary range coder: the same model code writes and reads.
//!
//! Everything a stream says is said through [`Coder`]. A writer passes the truth and gets it back; a reader passes
//! anything and gets what was written. So the code that models a stream exists once and the two sides cannot differ.
//! (Range coding after Martin 1979, with the carry resolved as in LZMA.)

/// Fewer counts make a model quick to forget; measured on ten meshes.
const MOST_SEEN: u16 = 160;
/// Below this the range is too short to be divided well.
const SHORT: u32 = 1 << 24;

/// How likely a bit is to be set, learnt from those before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bit {
    /// Of 65,536.
    chance: u16,
    seen: u16,
}

impl Bit {
    pub(super) const NEW: Self = Self { chance: 1 << 15, seen: 0 };

    fn learn(&mut self, bit: bool) {
        // The mean of what was seen at first, a sliding mean later.
        let step = RECIPROCAL[usize::from(self.seen)];
        let towards = if bit { 65_535 - u32::from(self.chance) } else { u32::from(self.chance) };
        let change = (towards * step) >> 16;
        // Never certain: the other bit must stay possible.
        self.chance = if bit {
            (u32::from(self.chance) + change).min(65_535 - CAUTION)
        } else {
            (u32::from(self.chance) - change).max(CAUTION)
        } as u16;
        self.seen += u16::from(self.seen < MOST_SEEN);
    }
}

/// The least chance, of 65,536.
const CAUTION: u32 = 24;

/// 65,536 / (n + 1.6): how far the n-th observation moves a chance.
const RECIPROCAL: [u32; MOST_SEEN as usize + 1] = {
    let mut table = [0; MOST_SEEN as usize + 1];
    let mut n = 0;
    while n < table.len() {
        table[n] = 655_360 / (10 * n as u32 + 16);
        n += 1;
    }
    table
};

/// Says bits, or hears them.
pub(super) trait Coder {
    /// Whether this is the side that knows.
    const WRITES: bool;
    /// A bit whose chances `model` knows.
    fn bit(&mut self, model: &mut Bit, bit: bool) -> bool;
    /// Up to 16 bits without a model.
    fn raw16(&mut self, bits: u32, value: u32) -> u32;

    /// Up to 32 bits without a model.
    fn raw(&mut self, bits: u32, value: u32) -> u32 {
        if bits <= 16 {
            return self.raw16(bits, value);
        }
        let high = self.raw16(bits - 16, value >> 16);
        high << 16 | self.raw16(16, value & 0xffff)
    }

    /// A number below `end`, all equally likely. `end` is at least 1.
    fn uniform(&mut self, end: u32, value: u32) -> u32 {
        let bits = end.ilog2();
        let short = if bits == 31 { u32::MAX - end + 1 } else { (2u32 << bits) - end };
        // The first `short` numbers take one bit less than the others.
        let (high, last) = if value < short { (value, 0) } else { ((value + short) >> 1, (value + short) & 1) };
        let high = self.raw(bits, high);
        if high < short { high } else { (high << 1 | self.raw16(1, last)).wrapping_sub(short) }
    }
}

/// The side that knows: makes bytes.
#[derive(Debug)]
pub(super) struct Encoder {
    low: u64,
    range: u32,
    /// The last byte that a carry could still change, and how many 0xff follow it.
    held: Option<u8>,
    full: usize,
    bytes: Vec<u8>,
}

impl Encoder {
    pub(super) fn new() -> Self {
        Self { low: 0, range: u32::MAX, held: None, full: 0, bytes: Vec::new() }
    }

    /// About how many bytes there are so far.
    pub(super) fn len(&self) -> usize {
        self.bytes.len() + self.full + 5
    }

    /// All bytes. A reader takes zeros for what is missing at the end.
    pub(super) fn finish(mut self) -> Vec<u8> {
        // The number in [low, low + range) with the most zeros at its end.
        let top = self.low + u64::from(self.range) - 1;
        let mut mask = u64::from(u32::MAX);
        while mask > 0 && top & !mask < self.low {
            mask >>= 1;
        }
        self.low = top & !mask;
        for _ in 0..5 {
            self.shift();
        }
        while self.bytes.last() == Some(&0) {
            self.bytes.pop();
        }
        self.bytes
    }

    fn shift(&mut self) {
        let carry = (self.low >> 32) as u8;
        if carry > 0 || self.low < 0xff00_0000 {
            if let Some(held) = self.held.replace((self.low >> 24) as u8) {
                self.bytes.push(held.wrapping_add(carry));
            }
            self.bytes.extend(std::iter::repeat_n(0xffu8.wrapping_add(carry), self.full));
            self.full = 0;
        } else {
            self.full += 1;
        }
        self.low = self.low << 8 & 0xffff_ffff;
    }

    fn normalise(&mut self) {
        while self.range < SHORT {
            self.range <<= 8;
            self.shift();
        }
    }
}

impl Coder for Encoder {
    const WRITES: bool = true;

    #[inline]
    fn bit(&mut self, model: &mut Bit, bit: bool) -> bool {
        let bound = (self.range >> 16) * u32::from(model.chance);
        if bit {
            self.range = bound;
        } else {
            self.low += u64::from(bound);
            self.range -= bound;
        }
        model.learn(bit);
        self.normalise();
        bit
    }

    #[inline]
    fn raw16(&mut self, bits: u32, value: u32) -> u32 {
        self.range >>= bits;
        self.low += u64::from(self.range) * u64::from(value);
        self.normalise();
        value
    }
}

/// The side that hears: reads bytes, and zeros behind them.
#[derive(Debug)]
pub(super) struct Decoder<'a> {
    code: u32,
    range: u32,
    bytes: &'a [u8],
    /// Bytes taken that were not there.
    missing: usize,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let mut new = Self { code: 0, range: u32::MAX, bytes, missing: 0 };
        for _ in 0..4 {
            new.take();
        }
        new
    }

    /// Whether it has gone on far behind the end: what it hears then was never said.
    pub(super) fn is_lost(&self) -> bool {
        self.missing > 5
    }

    fn take(&mut self) {
        let byte = match self.bytes.split_first() {
            Some((&byte, rest)) => {
                self.bytes = rest;
                byte
            }
            None => {
                self.missing += 1;
                0
            }
        };
        self.code = self.code << 8 | u32::from(byte);
    }

    fn normalise(&mut self) {
        while self.range < SHORT {
            self.range <<= 8;
            self.take();
        }
    }
}

impl Coder for Decoder<'_> {
    const WRITES: bool = false;

    #[inline]
    fn bit(&mut self, model: &mut Bit, _: bool) -> bool {
        let bound = (self.range >> 16) * u32::from(model.chance);
        let bit = self.code < bound;
        if bit {
            self.range = bound;
        } else {
            self.code -= bound;
            self.range -= bound;
        }
        model.learn(bit);
        self.normalise();
        bit
    }

    #[inline]
    fn raw16(&mut self, bits: u32, _: u32) -> u32 {
        self.range >>= bits;
        // A crafted stream may point behind the range.
        let value = (self.code / self.range).min((1 << bits) - 1);
        self.code = self.code.wrapping_sub(value.wrapping_mul(self.range));
        self.normalise();
        value
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
        let mut said = Vec::new();
        for i in 0..20_000 {
            let skew = [2, 10, 1000, 100_000][i % 4];
            said.push(u32::from(coder.bit(&mut models[i % 4], (random.below(skew) == 0) ^ wrong)));
            let bits = random.below(33) as u32;
            let end = (1 + random.next() % u64::from(u32::MAX >> random.below(32))) as u32;
            let value = (random.next() & ((1u64 << bits) - 1)) as u32;
            said.push(coder.raw(bits, if wrong { 0 } else { value }));
            said.push(
                coder.uniform(
                    end,
                    if wrong { 0 * random.next() as u32 } else { (random.next() % u64::from(end)) as u32 },
                ),
            );
        }
        said
    }

    #[test]
    fn what_is_said_is_heard() {
        for seed in 0..20 {
            let mut encoder = Encoder::new();
            let said = say(&mut encoder, &mut Random(seed));
            let bytes = encoder.finish();
            let mut decoder = Decoder::new(&bytes);
            let mut random = Random(seed);
            assert_eq!(say(&mut decoder, &mut random), said, "seed {seed}");
            assert!(!decoder.is_lost(), "seed {seed}");
        }
    }

    #[test]
    fn likely_bits_take_little_room() {
        let mut encoder = Encoder::new();
        let mut model = Bit::NEW;
        for _ in 0..80_000 {
            encoder.bit(&mut model, true);
        }
        assert!(encoder.finish().len() < 60);
        assert!(Encoder::new().finish().is_empty());
    }
}
