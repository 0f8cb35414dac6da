//! The encoder of a substream. It collects intervals and plain bits, and at the end encodes the
//! intervals backwards, since asymmetric numeral systems are last in, first out. The figure is in
//! `entropy/mod.rs`.

use crate::entropy::adaptive_probability::{
    AdaptiveBit, AdaptiveSymbol, Interval, PROBABILITY_BITS, TOTAL,
};
use crate::entropy::coder::Coder;
use crate::entropy::decoder::{MIN_STATE, STATE_BYTES};

/// Collects coded values and makes a substream of them.
#[derive(Debug, Default)]
pub(crate) struct Encoder {
    /// Intervals of all values with adaptive probabilities. A decoder reads last what is encoded
    /// first, so they are encoded backwards at the end.
    intervals: Vec<Interval>,
    /// Estimated length of `intervals` once encoded, in 1/256 bit.
    interval_cost: u64,
    /// Bytes of plain bits; the first bit is the lowest of the first byte.
    plain: Vec<u8>,
    /// Plain bits that are not in `plain` yet, from the lowest on.
    pending: u64,
    /// Number of bits in `pending`.
    pending_bits: u32,
}

impl Encoder {
    /// Returns the estimated length so far in bytes.
    pub(crate) fn len(&self) -> usize {
        (self.interval_cost >> 11) as usize + self.plain.len() + STATE_BYTES
    }

    /// Encodes everything that was collected.
    pub(crate) fn finish(mut self) -> EncodedSubstream {
        let mut state = MIN_STATE;
        let mut words: Vec<u16> = Vec::new();
        for interval in self.intervals.iter().rev() {
            let frequency = u32::from(interval.frequency);
            if state >> (32 - PROBABILITY_BITS) >= frequency {
                words.push(state as u16);
                state >>= 16;
            }
            let slot = state % frequency + u32::from(interval.start);
            state = (state / frequency) << PROBABILITY_BITS | slot;
        }
        let mut front = state.to_le_bytes().to_vec();
        front.extend(words.iter().rev().flat_map(|w| w.to_le_bytes()));
        if self.intervals.is_empty() && self.plain.is_empty() && self.pending_bits == 0 {
            front.clear();
        }
        let pending = self.pending.to_le_bytes();
        self.plain.extend_from_slice(&pending[..self.pending_bits.div_ceil(8) as usize]);
        self.plain.reverse();
        EncodedSubstream { front, back: self.plain }
    }

    #[inline]
    fn push(&mut self, interval: Interval) {
        self.intervals.push(interval);
        // The negative binary logarithm, linear between powers of two.
        let log = interval.frequency.ilog2();
        let fraction = (u32::from(interval.frequency) << (PROBABILITY_BITS - log)
            & u32::from(TOTAL - 1))
            >> (PROBABILITY_BITS - 8);
        self.interval_cost += u64::from(((PROBABILITY_BITS - log) << 8) - fraction);
    }
}

impl Coder for Encoder {
    const ENCODES: bool = true;

    #[inline]
    fn bit(&mut self, context: &mut AdaptiveBit, bit: bool) -> bool {
        self.push(context.interval(bit));
        context.update(bit);
        bit
    }

    #[inline]
    fn symbol(&mut self, context: &mut AdaptiveSymbol, value: u32) -> u32 {
        let symbol = value as usize & 15;
        self.push(context.interval(symbol));
        context.update(symbol);
        value
    }

    #[inline]
    fn raw(&mut self, bits: u32, value: u32) -> u32 {
        self.pending |= u64::from(value) << self.pending_bits;
        self.pending_bits += bits;
        if self.pending_bits >= 32 {
            self.plain.extend_from_slice(&(self.pending as u32).to_le_bytes());
            self.pending >>= 32;
            self.pending_bits -= 32;
        }
        value
    }
}

/// A finished substream: its two ends, between which there may be padding.
#[derive(Clone, Debug, Default)]
pub(crate) struct EncodedSubstream {
    front: Vec<u8>,
    back: Vec<u8>,
}

impl EncodedSubstream {
    /// Returns the bytes, with `padding` zero bytes between the two ends.
    pub(crate) fn into_bytes(mut self, padding: usize) -> Vec<u8> {
        self.front.resize(self.front.len() + padding, 0);
        self.front.append(&mut self.back);
        self.front
    }

    pub(crate) fn len(&self) -> usize {
        self.front.len() + self.back.len()
    }
}
