//! Numbers made of modelled symbols and plain bits.

use super::chances::Symbol;
use super::coder::Coder;

/// A signed number of which is known about how many bits it has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Residual(Symbol);

/// The symbol of a magnitude that is as long as expected. 0 is for no bits, [`FAR`] for those too
/// far away for a symbol.
const EXPECTED: i32 = 10;
const FAR: u32 = 15;

impl Residual {
    pub(super) const NEW: Self = Self(Symbol::NEW);

    /// A number with a magnitude of about `expected` bits (32 at most). Returns it with the bits of
    /// its magnitude.
    #[inline]
    pub(super) fn code<C: Coder>(
        &mut self,
        coder: &mut C,
        expected: u32,
        value: i64,
    ) -> (i64, u32) {
        let magnitude = value.unsigned_abs() as u32;
        let length = bits(magnitude);
        let near = length as i32 - expected as i32 + EXPECTED;
        let symbol = match near {
            _ if length == 0 => 0,
            1..=14 => near as u32,
            _ => FAR,
        };
        let length = match coder.symbol(&mut self.0, symbol) {
            0 => return (0, 0),
            FAR => coder.uniform(32, length.wrapping_sub(1)) + 1,
            near => (near as i32 - EXPECTED + expected as i32).clamp(1, 32) as u32,
        };
        // The bits below the highest, and the sign: nothing is known of these.
        let low = coder.raw(length - 1, magnitude & !(1 << (length - 1)));
        let magnitude = i64::from(1 << (length - 1) | low);
        let negative = coder.raw(1, u32::from(value < 0)) == 1;
        (if negative { -magnitude } else { magnitude }, length)
    }
}

/// A natural number of any size: its length learnt, the bits below its highest not.
#[derive(Clone, Debug)]
pub(super) struct Natural {
    length: Symbol,
    rest: [Symbol; 9],
}

impl Natural {
    pub(super) const NEW: Self = Self { length: Symbol::NEW, rest: [Symbol::NEW; 9] };

    pub(super) fn code<C: Coder>(&mut self, coder: &mut C, value: u32) -> u32 {
        let length = bits(value);
        let high = coder.symbol(&mut self.length, length >> 2).min(8);
        let low = coder.symbol(&mut self.rest[high as usize], length & 3) & 3;
        let length = (high << 2 | low).min(32);
        if length <= 1 {
            return length;
        }
        let below = length - 1;
        1 << below | coder.raw(below, value & ((1 << below) - 1))
    }
}

/// A number below a bound that is known, mostly near it on a scale of powers.
#[derive(Clone, Debug)]
pub(super) struct Below(Symbol);

impl Below {
    pub(super) const NEW: Self = Self(Symbol::NEW);

    /// A number below `end`, which is at least 1.
    pub(super) fn code<C: Coder>(&mut self, coder: &mut C, end: u32, value: u32) -> u32 {
        let most = bits(end - 1);
        let shorter = coder.symbol(&mut self.0, (most - bits(value).min(most)).min(15));
        let length = most.saturating_sub(shorter);
        if shorter == 15 {
            return coder.raw(length, value);
        }
        if length <= 1 {
            return length;
        }
        let half = 1 << (length - 1);
        let rest = value.wrapping_sub(half);
        half + if shorter == 0 {
            coder.uniform(end - half, rest)
        } else {
            coder.raw(length - 1, rest)
        }
    }
}

/// How many bits a number has: 0 for 0.
#[inline]
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
        let hidden = |value: u32| if C::WRITES { value } else { 0 };
        let mut residual = Residual::NEW;
        let (mut natural, mut below) = (Natural::NEW, Below::NEW);
        let mut said = Vec::new();
        for _ in 0..5_000 {
            let expected = random.below(33) as u32;
            let magnitude = (random.next() >> 32 >> random.below(33)) as u32;
            let sign = if random.below(2) == 0 { 1 } else { -1 };
            let value = sign * i64::from(hidden(magnitude));
            said.push(residual.code(coder, expected, value).0);
            said.push(i64::from(
                natural.code(coder, hidden((random.next() >> 32 >> random.below(33)) as u32)),
            ));
            let end = (random.next() >> 32 >> random.below(32)).max(1) as u32;
            let value = (random.next() % u64::from(end)) as u32;
            said.push(i64::from(below.code(coder, end, hidden(value))));
        }
        for edge in [0, 1, -1, i64::from(u32::MAX), -i64::from(u32::MAX)] {
            for expected in 0..33 {
                let value = if C::WRITES { edge } else { 0 };
                said.push(residual.code(coder, expected, value).0);
            }
        }
        said
    }

    #[test]
    fn numbers_are_heard_as_they_were_said() {
        for seed in 0..10 {
            let mut encoder = Encoder::default();
            let said = say(&mut encoder, &mut Random(seed));
            let bytes = encoder.finish().bytes(0);
            let mut decoder = Decoder::new(&bytes);
            assert_eq!(say(&mut decoder, &mut Random(seed)), said, "seed {seed}");
            assert!(decoder.is_done());
        }
    }
}
