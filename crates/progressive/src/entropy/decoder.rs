//! The decoder of a substream: asymmetric numeral systems (Duda 2013, range variant, 32-bit state)
//! from the front, plain bits from the back. The figure is in `entropy/mod.rs`.

use crate::entropy::adaptive_probability::{
    AdaptiveBit, AdaptiveSymbol, Interval, PROBABILITY_BITS, TOTAL,
};
use crate::entropy::coder::Coder;

/// Least state of the numeral system: below it a decoder takes the next two bytes.
pub(crate) const MIN_STATE: u32 = 1 << 16;
/// Bytes of the state at the front.
pub(crate) const STATE_BYTES: usize = 4;

/// Reads a substream; beyond its ends it reads zeros.
#[derive(Debug)]
pub(crate) struct Decoder<'a> {
    /// The state of the numeral system.
    state: u32,
    bytes: &'a [u8],
    /// Bytes taken from the front.
    front: usize,
    /// Bytes taken from the back.
    back: usize,
    /// Plain bits that were taken from the back and not used yet, from the lowest on.
    pending: u64,
    /// Number of bits in `pending`.
    pending_bits: u32,
}

impl<'a> Decoder<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        let mut decoder =
            Self { state: MIN_STATE, bytes, front: 0, back: 0, pending: 0, pending_bits: 0 };
        if let Some(state) = bytes.get(..STATE_BYTES) {
            decoder.state = state.iter().rev().fold(0, |all, &byte| all << 8 | u32::from(byte));
            decoder.front = STATE_BYTES;
        }
        decoder
    }

    /// Returns whether more was read than the substream has.
    pub(crate) fn is_exhausted(&self) -> bool {
        self.front + self.back > self.bytes.len() + self.pending_bits as usize / 8
    }

    /// Returns whether everything with adaptive probabilities was read, and nothing else.
    pub(crate) fn is_finished(&self) -> bool {
        self.state == MIN_STATE && !self.is_exhausted()
    }

    /// Takes a value off the state, given its interval and the state's slot, and refills the state.
    #[inline]
    fn advance(&mut self, interval: Interval, slot: u16) {
        self.state = u32::from(interval.frequency) * (self.state >> PROBABILITY_BITS)
            + u32::from(slot.wrapping_sub(interval.start));
        if self.state < MIN_STATE {
            let word = self
                .bytes
                .get(self.front..)
                .and_then(<[u8]>::first_chunk)
                .copied()
                .unwrap_or_default();
            self.state = self.state << 16 | u32::from(u16::from_le_bytes(word));
            self.front += 2;
        }
    }

    /// The number in 0..[`TOTAL`] whose interval is that of the next value.
    fn slot(&self) -> u16 {
        self.state as u16 & (TOTAL - 1)
    }

    /// Takes four bytes from the back.
    #[inline]
    fn refill(&mut self) {
        let end = self.bytes.len().saturating_sub(self.back);
        let bytes4 = match self.bytes[..end].last_chunk() {
            Some(bytes4) => *bytes4,
            None => std::array::from_fn(|i| if i + end >= 4 { self.bytes[i + end - 4] } else { 0 }),
        };
        self.pending |= u64::from(u32::from_be_bytes(bytes4)) << self.pending_bits;
        self.pending_bits += 32;
        self.back += 4;
    }
}

impl Coder for Decoder<'_> {
    const ENCODES: bool = false;

    #[inline]
    fn bit(&mut self, context: &mut AdaptiveBit, _: bool) -> bool {
        let slot = self.slot();
        let bit = slot < context.frequency();
        self.advance(context.interval(bit), slot);
        context.update(bit);
        bit
    }

    #[inline(always)]
    fn symbol(&mut self, context: &mut AdaptiveSymbol, _: u32) -> u32 {
        let slot = self.slot();
        let symbol = context.symbol_at(slot);
        self.advance(context.interval(symbol), slot);
        context.update(symbol);
        symbol as u32
    }

    #[inline]
    fn raw(&mut self, bits: u32, _: u32) -> u32 {
        if self.pending_bits < bits {
            self.refill();
        }
        let value = self.pending & ((1 << bits) - 1);
        self.pending >>= bits;
        self.pending_bits -= bits;
        value as u32
    }
}
