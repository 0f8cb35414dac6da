//! What the local searches share: a seeded generator and the rule that lets a search climb a
//! little.

/// A small generator of pseudo-random numbers (SplitMix64): the same everywhere.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x2545_f491_4f6c_dd1d)
    }
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }
}

/// A number below `n` from the upper half of some random bits.
pub(crate) fn below(bits: u64, n: usize) -> usize {
    (((bits >> 32) * n as u64) >> 32) as usize
}

/// e⁻ˣ for x ≥ 0 to about a thousandth, by products and quotients only: the same bits on every
/// machine.
pub(crate) fn exp_minus(x: f64) -> f64 {
    let mut p = 1.0 / (1.0 + x / 4096.0 + x * x / (2.0 * 4096.0 * 4096.0));
    for _ in 0..12 {
        p *= p;
    }
    p
}
