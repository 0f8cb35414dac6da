//! Adaptive probabilities: estimates of how likely a bit, or each of sixteen symbols, is; updated
//! after each use. They divide the range 0 to 2^15 among the values, as the coder for asymmetric
//! numeral systems (`encoder`, `decoder`) needs it. All constants here are part of the format.

/// Binary logarithm of [`TOTAL`].
pub(crate) const PROBABILITY_BITS: u32 = 15;
/// Sum of the frequencies of all values: 2^15.
pub(crate) const TOTAL: u16 = 1 << PROBABILITY_BITS;

/// Observations after which the rate of adaptation no longer falls. Fewer forget faster; chosen by
/// the sizes of ten meshes, whose figures are not kept.
const MAX_COUNT: u8 = 160;
/// Least probability of either value of a bit, in 1/65,536: both must stay possible. Chosen by
/// hand: a higher one costs bits where one value is nearly certain.
const MIN_PROBABILITY: u32 = 24;
/// Least frequency of a symbol, of [`TOTAL`], so that all stay possible: one costs 13 bits at most.
/// Chosen by hand.
const MIN_FREQUENCY: i16 = 4;
/// Sum of the adaptive parts of all frequencies.
const ADAPTIVE_TOTAL: i16 = (TOTAL - 16 * MIN_FREQUENCY as u16) as i16;

/// Rate of adaptation after `n` observations, in 1/65,536: 1 / (n + 1.6). Estimates are a mean at
/// first and a sliding mean later.
const RATES: [u16; 256] = {
    let mut rates = [0; 256];
    let mut n = 0;
    while n < rates.len() {
        rates[n] = (655_360 / (10 * n as u32 + 16)) as u16;
        n += 1;
    }
    rates
};

/// The interval of the range 0 to [`TOTAL`] that belongs to one value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Interval {
    /// First number of the interval: the cumulative frequency of all smaller values.
    pub(crate) start: u16,
    /// Length of the interval: the value's frequency.
    pub(crate) frequency: u16,
}

/// The adaptive probability of one binary decision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AdaptiveBit {
    /// Probability that the bit is set, in 1/65,536.
    probability: u16,
    /// Observations so far, up to [`MAX_COUNT`].
    count: u8,
}

impl AdaptiveBit {
    pub(crate) const NEW: Self = Self { probability: 1 << 15, count: 0 };

    /// Returns the frequency of a set bit, of [`TOTAL`].
    pub(crate) fn frequency(self) -> u16 {
        self.probability >> 1
    }

    /// Returns the interval of a value: a set bit comes first.
    pub(crate) fn interval(self, bit: bool) -> Interval {
        let set = self.frequency();
        if bit {
            Interval { start: 0, frequency: set }
        } else {
            Interval { start: set, frequency: TOTAL - set }
        }
    }

    /// Moves the estimate towards an observed value.
    #[inline]
    pub(crate) fn update(&mut self, bit: bool) {
        let rate = u32::from(RATES[usize::from(self.count)]);
        let probability = u32::from(self.probability);
        let raised =
            (probability + (((65_535 - probability) * rate) >> 16)).min(65_535 - MIN_PROBABILITY);
        let lowered = (probability - ((probability * rate) >> 16)).max(MIN_PROBABILITY);
        self.probability = if bit { raised } else { lowered } as u16;
        self.count += u8::from(self.count < MAX_COUNT);
    }
}

/// The adaptive probabilities of sixteen symbols.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AdaptiveSymbol {
    /// Cumulative frequency below each symbol, without the [`MIN_FREQUENCY`] of each.
    cumulative: [i16; 16],
    /// Observations so far, with the initial ones, up to [`MAX_COUNT`].
    count: u8,
}

/// The values that cumulative frequencies move towards when each symbol is observed.
const UPDATE_TARGETS: [[i16; 16]; 16] = {
    let mut targets = [[0; 16]; 16];
    let mut i = 0;
    while i < 256 {
        targets[i / 16][i % 16] = if i % 16 > i / 16 { ADAPTIVE_TOTAL } else { 0 };
        i += 1;
    }
    targets
};

/// Observations that a new symbol context starts with, so that the first symbol does not take
/// nearly all of the probability. A constant of the format; not measured.
const INITIAL_SYMBOL_COUNT: u8 = 2;

impl AdaptiveSymbol {
    pub(crate) const NEW: Self = {
        let mut cumulative = [0; 16];
        let mut i = 0;
        while i < 16 {
            cumulative[i] = ADAPTIVE_TOTAL / 16 * i as i16;
            i += 1;
        }
        Self { cumulative, count: INITIAL_SYMBOL_COUNT }
    };

    /// Returns the symbol whose interval holds `slot`, a number below [`TOTAL`].
    #[inline(always)]
    pub(crate) fn symbol_at(&self, slot: u16) -> usize {
        // A count without branches, which compiles to vector instructions.
        let mut symbols = 0;
        for (i, &below) in (0i16..).zip(&self.cumulative) {
            symbols += i16::from(below + MIN_FREQUENCY * i <= slot as i16);
        }
        (symbols - 1) as usize & 15
    }

    /// Returns the interval of a symbol.
    #[inline(always)]
    pub(crate) fn interval(&self, symbol: usize) -> Interval {
        let start_of = |s: usize| (self.cumulative[s & 15] + MIN_FREQUENCY * s as i16) as u16;
        let start = start_of(symbol);
        let end = if symbol == 15 { TOTAL } else { start_of(symbol + 1) };
        Interval { start, frequency: end - start }
    }

    /// Moves the estimates towards an observed symbol.
    #[inline(always)]
    pub(crate) fn update(&mut self, symbol: usize) {
        let rate = RATES[usize::from(self.count)] as i16;
        for (below, target) in self.cumulative.iter_mut().zip(&UPDATE_TARGETS[symbol & 15]) {
            *below += ((i32::from(target - *below) * i32::from(rate)) >> 16) as i16;
        }
        self.count += u8::from(self.count < MAX_COUNT);
    }
}
