//! The trait through which all code that models a stream reads and writes it.

use crate::entropy::adaptive_probability::{AdaptiveBit, AdaptiveSymbol};

/// Codes values. An encoder is given each value and returns it; a decoder ignores the argument and
/// returns the value that was encoded.
///
/// All code that models a stream is generic over this trait, so it exists once and the two sides
/// cannot differ.
pub(crate) trait Coder {
    /// True for the encoder.
    const ENCODES: bool;
    /// Codes a bit by its adaptive probability.
    fn bit(&mut self, context: &mut AdaptiveBit, bit: bool) -> bool;
    /// Codes a number below 16 by its adaptive probabilities.
    fn symbol(&mut self, context: &mut AdaptiveSymbol, value: u32) -> u32;
    /// Codes the lowest `bits` bits of a number as they are, up to 32.
    fn raw(&mut self, bits: u32, value: u32) -> u32;

    /// Codes a number below `end`, all equally likely, in a truncated binary code. `end` is at
    /// least 1.
    #[inline]
    fn uniform(&mut self, end: u32, value: u32) -> u32 {
        let bits = end.ilog2();
        // The first numbers take `bits` bits, the others one more: how many short ones there are.
        let short_codes = if bits == 31 { u32::MAX - end + 1 } else { (2u32 << bits) - end };
        let (high, lowest_bit) = if value < short_codes {
            (value, 0)
        } else {
            (value.wrapping_add(short_codes) >> 1, value.wrapping_add(short_codes) & 1)
        };
        let high = self.raw(bits, high);
        if high < short_codes {
            high
        } else {
            (high << 1 | self.raw(1, lowest_bit)).wrapping_sub(short_codes)
        }
    }
}
