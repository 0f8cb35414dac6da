//! The trait through which all modelling code reads and writes a substream: an encoder takes each
//! value, a decoder ignores the argument and returns the value that was encoded.

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
    /// Codes up to 32 plain bits.
    fn raw(&mut self, bits: u32, value: u32) -> u32;

    /// Codes a number below `end`, all equally likely, in a truncated binary code. `end` is at
    /// least 1.
    #[inline]
    fn uniform(&mut self, end: u32, value: u32) -> u32 {
        let bits = end.ilog2();
        let short = if bits == 31 { u32::MAX - end + 1 } else { (2u32 << bits) - end };
        // The first `short` numbers take one bit less than the others.
        let (high, lowest_bit) = if value < short {
            (value, 0)
        } else {
            (value.wrapping_add(short) >> 1, value.wrapping_add(short) & 1)
        };
        let high = self.raw(bits, high);
        if high < short { high } else { (high << 1 | self.raw(1, lowest_bit)).wrapping_sub(short) }
    }
}
