//! Codes for integers: the bit length is an adaptive symbol; the bits below the highest one are
//! plain. There is one for residuals (signed, of an expected length), one for numbers of any size,
//! and one for numbers below a bound.

use crate::entropy::adaptive_probability::AdaptiveSymbol;
use crate::entropy::coder::Coder;

/// Code of a signed residual whose bit length can be estimated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResidualCode(pub(crate) AdaptiveSymbol);

/// Symbol of a magnitude as long as expected: up to 9 bits fewer and 4 more have symbols, since
/// residuals are smaller than expected more often than larger. Symbol 0 is a residual of 0.
const EXPECTED_LENGTH_SYMBOL: i32 = 10;
/// Symbol of a length too far from the expected one: the length follows as a plain number.
const LENGTH_ESCAPE: u32 = 15;
/// Symbol of a [`BoundedCode`] whose number is at least this many bits shorter than its bound: all
/// bits follow plain.
const SHORTEST_SYMBOL: u32 = 15;

/// A residual and the bit length of its magnitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CodedResidual {
    pub(crate) value: i64,
    /// Bit length of the magnitude; 0 for a residual of 0.
    pub(crate) bits: u32,
}

impl ResidualCode {
    pub(crate) const NEW: Self = Self(AdaptiveSymbol::NEW);

    /// Codes a residual whose magnitude is estimated to have `expected` bits, at most 32.
    #[inline]
    pub(crate) fn code<C: Coder>(
        &mut self,
        coder: &mut C,
        expected: u32,
        value: i64,
    ) -> CodedResidual {
        let magnitude = value.unsigned_abs() as u32;
        let length = bit_length(magnitude);
        let relative = length as i32 - expected as i32 + EXPECTED_LENGTH_SYMBOL;
        let symbol = match relative {
            _ if length == 0 => 0,
            1..=14 => relative as u32,
            _ => LENGTH_ESCAPE,
        };
        let length = match coder.symbol(&mut self.0, symbol) {
            0 => return CodedResidual { value: 0, bits: 0 },
            LENGTH_ESCAPE => coder.uniform(32, length.wrapping_sub(1)) + 1,
            symbol => {
                (symbol as i32 - EXPECTED_LENGTH_SYMBOL + expected as i32).clamp(1, 32) as u32
            }
        };
        // The bits below the highest, and the sign, are equally likely to be set or not.
        let low = coder.raw(length - 1, magnitude & !(1 << (length - 1)));
        let magnitude = i64::from(1 << (length - 1) | low);
        let negative = coder.raw(1, u32::from(value < 0)) == 1;
        CodedResidual { value: if negative { -magnitude } else { magnitude }, bits: length }
    }
}

/// Code of a natural number of any size: an Elias gamma code whose length is adaptive.
#[derive(Clone, Debug)]
pub(crate) struct GammaCode {
    /// The bit length divided by 4, rounded down.
    pub(crate) length_high: AdaptiveSymbol,
    /// The bit length modulo 4: a context for each value of `length_high`.
    pub(crate) length_low: [AdaptiveSymbol; 9],
}

impl GammaCode {
    pub(crate) const NEW: Self =
        Self { length_high: AdaptiveSymbol::NEW, length_low: [AdaptiveSymbol::NEW; 9] };

    pub(crate) fn code<C: Coder>(&mut self, coder: &mut C, value: u32) -> u32 {
        let length = bit_length(value);
        let high = coder.symbol(&mut self.length_high, length >> 2).min(8);
        let low = coder.symbol(&mut self.length_low[high as usize], length & 3) & 3;
        let length = (high << 2 | low).min(32);
        if length <= 1 {
            return length;
        }
        let low_bits = length - 1;
        1 << low_bits | coder.raw(low_bits, value & ((1 << low_bits) - 1))
    }
}

/// Code of a number below a known bound: how many bits it is shorter than the bound, adaptively.
#[derive(Clone, Debug)]
pub(crate) struct BoundedCode(pub(crate) AdaptiveSymbol);

impl BoundedCode {
    pub(crate) const NEW: Self = Self(AdaptiveSymbol::NEW);

    /// Codes a number below `end`, which is at least 1.
    pub(crate) fn code<C: Coder>(&mut self, coder: &mut C, end: u32, value: u32) -> u32 {
        let longest = bit_length(end - 1);
        let saved = (longest - bit_length(value).min(longest)).min(SHORTEST_SYMBOL);
        let saved = coder.symbol(&mut self.0, saved);
        let length = longest.saturating_sub(saved);
        if saved == SHORTEST_SYMBOL {
            return coder.raw(length, value);
        }
        if length <= 1 {
            return length;
        }
        let half = 1 << (length - 1);
        let offset = value.wrapping_sub(half);
        half + if saved == 0 {
            coder.uniform(end - half, offset)
        } else {
            coder.raw(length - 1, offset)
        }
    }
}

/// Returns the number of bits of a number without leading zeros: 0 for 0.
#[inline]
pub(crate) fn bit_length(value: u32) -> u32 {
    u32::BITS - value.leading_zeros()
}
