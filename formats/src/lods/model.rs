//! Numbers made of modelled bits.

use super::coder::{Bit, Coder};

/// A number of `BITS` bits, its chances learnt: the highest bit first, each in the light of those before it.
#[derive(Clone, Debug)]
pub(super) struct Tree<const NODES: usize>([Bit; NODES]);

impl<const NODES: usize> Tree<NODES> {
    pub(super) const NEW: Self = Self([Bit::NEW; NODES]);

    /// A number below `NODES`, which is a power of two.
    pub(super) fn code<C: Coder>(&mut self, coder: &mut C, value: u32) -> u32 {
        let mut node = 1;
        let mut bit = NODES as u32 >> 1;
        while bit > 0 {
            node = node << 1 | usize::from(coder.bit(&mut self.0[node], value & bit != 0));
            bit >>= 1;
        }
        (node - NODES) as u32
    }
}

/// A number that is mostly small: as many set bits as it counts, up to `MOST`.
#[derive(Clone, Debug)]
pub(super) struct Unary<const MOST: usize>([Bit; MOST]);

impl<const MOST: usize> Unary<MOST> {
    pub(super) const NEW: Self = Self([Bit::NEW; MOST]);

    /// A number of at most `MOST`.
    pub(super) fn code<C: Coder>(&mut self, coder: &mut C, value: u32) -> u32 {
        let mut n = 0;
        while n < MOST && coder.bit(&mut self.0[n], (n as u32) < value) {
            n += 1;
        }
        n as u32
    }
}

/// Bits that a magnitude of `class` has below its highest and that are still worth a model.
const MODELLED: u32 = 2;

/// A signed number whose magnitude is known roughly beforehand.
#[derive(Clone, Debug)]
pub(super) struct Residual {
    smaller: Bit,
    less: Unary<34>,
    more: Unary<34>,
    negative: [Bit; 3],
    /// By the distance of the class from the expected one.
    top: [Tree<4>; 8],
}

impl Residual {
    pub(super) const NEW: Self =
        Self { smaller: Bit::NEW, less: Unary::NEW, more: Unary::NEW, negative: [Bit::NEW; 3], top: [Tree::NEW; 8] };

    /// A number with a magnitude of about `expected` bits; `lean` (0, 1 or 2) is a guess at its sign. Returns it with the
    /// bits of its magnitude.
    pub(super) fn code<C: Coder>(&mut self, coder: &mut C, expected: u32, lean: usize, value: i64) -> (i64, u32) {
        let magnitude = value.unsigned_abs() as u32;
        let class = bits(magnitude);
        let class = if coder.bit(&mut self.smaller, class < expected) {
            let less = self.less.code(coder, expected.wrapping_sub(class).wrapping_sub(1));
            expected.saturating_sub(less + 1)
        } else {
            (expected + self.more.code(coder, class.wrapping_sub(expected))).min(32)
        };
        if class == 0 {
            return (0, 0);
        }
        let distance = (class + 4).saturating_sub(expected).min(7) as usize;
        let below = class - 1;
        let rest = magnitude & !(1 << below);
        let rest = match below {
            0 => 0,
            // Small numbers: every bit has its chances.
            1..=MODELLED => self.top[distance].code(coder, rest << (MODELLED - below) & 3) >> (MODELLED - below),
            _ => {
                let low = below - MODELLED;
                let high = self.top[distance].code(coder, rest >> low);
                high << low | coder.raw(low, rest & ((1 << low) - 1))
            }
        };
        let magnitude = i64::from(1 << below | rest);
        let negative = coder.bit(&mut self.negative[lean], value < 0);
        (if negative { -magnitude } else { magnitude }, class)
    }
}

/// A natural number of any size: its length learnt, the bits below its two highest not.
#[derive(Clone, Debug)]
pub(super) struct Natural {
    length: Tree<64>,
    top: [Bit; 33],
}

impl Natural {
    pub(super) const NEW: Self = Self { length: Tree::NEW, top: [Bit::NEW; 33] };

    pub(super) fn code<C: Coder>(&mut self, coder: &mut C, value: u32) -> u32 {
        let length = self.length.code(coder, bits(value)).min(32);
        if length <= 1 {
            return length;
        }
        let below = length - 2;
        let next = coder.bit(&mut self.top[length as usize], value >> below & 1 == 1);
        let low = coder.raw(below, value & ((1 << below) - 1));
        (2 | u32::from(next)) << below | low
    }
}

/// How many bits a number has: 0 for 0.
pub(super) fn bits(value: u32) -> u32 {
    u32::BITS - value.leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::super::coder::{Decoder, Encoder};
    use super::*;
    use crate::testing::Random;

    fn say<C: Coder>(coder: &mut C, random: &mut Random) -> Vec<i64> {
        // A reader does not know the truth.
        let wrong = if C::WRITES { 0 } else { 77 };
        let (mut tree, mut unary) = (Tree::<16>::NEW, Unary::<5>::NEW);
        let (mut residual, mut natural) = (Residual::NEW, Natural::NEW);
        let mut said = Vec::new();
        for _ in 0..5_000 {
            said.push(i64::from(tree.code(coder, random.below(16) as u32 ^ (wrong & 15))));
            said.push(i64::from(unary.code(coder, random.below(6) as u32 ^ wrong)));
            let (expected, lean) = (random.below(34) as u32, random.below(3));
            let magnitude = (random.next() >> 32 >> random.below(33)) as i64;
            let sign = if random.below(2) == 0 { 1 } else { -1 };
            said.push(residual.code(coder, expected, lean, sign * magnitude ^ i64::from(wrong)).0);
            said.push(i64::from(natural.code(coder, (random.next() >> 32 >> random.below(33)) as u32 ^ wrong)));
        }
        for edge in [0, 1, -1, i64::from(u32::MAX), -i64::from(u32::MAX)] {
            for expected in 0..34 {
                said.push(residual.code(coder, expected, 0, edge ^ i64::from(wrong)).0);
            }
        }
        said
    }

    #[test]
    fn numbers_are_heard_as_they_were_said() {
        for seed in 0..10 {
            let mut encoder = Encoder::new();
            let said = say(&mut encoder, &mut Random(seed));
            let bytes = encoder.finish();
            let mut decoder = Decoder::new(&bytes);
            assert_eq!(say(&mut decoder, &mut Random(seed)), said, "seed {seed}");
            assert!(!decoder.is_lost());
        }
    }
}
