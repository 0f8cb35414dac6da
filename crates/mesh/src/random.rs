//! A small seeded generator of pseudo-random numbers: the same on every machine.

/// `SplitMix64` (Steele, Lea and Flood 2014). Equal seeds give equal sequences.
#[derive(Clone, Debug)]
pub struct SplitMix64(u64);

/// 2⁶⁴ divided by the golden ratio, odd: the increment of the generator.
const GOLDEN_GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

impl SplitMix64 {
    /// A generator for a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN_GAMMA);
        Self::mix(self.0)
    }

    /// Returns a number from 0 to `n − 1`. `n` must not be 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }

    /// Returns a number in `[0, 1)` with 24 random bits: an exact `f32`.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    /// The `i`-th output of the generator for `seed`, without running through those before it.
    #[must_use]
    pub fn at(seed: u64, i: u64) -> u64 {
        Self::mix(seed.wrapping_add(i.wrapping_add(1).wrapping_mul(GOLDEN_GAMMA)))
    }

    /// The finaliser: a bijection of 64 bits in which every input bit changes about half of the
    /// output.
    #[must_use]
    #[inline]
    pub fn mix(bits: u64) -> u64 {
        let z = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_gives_the_published_sequence() {
        // The first outputs of Vigna's splitmix64.c for seed 1234567.
        let mut random = SplitMix64::new(1_234_567);
        let first: [u64; 3] = std::array::from_fn(|_| random.bits());
        let published =
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!(first, published);
        assert_eq!([0, 1, 2].map(|i| SplitMix64::at(1_234_567, i)), published);
    }

    #[test]
    fn numbers_stay_in_their_ranges() {
        let mut random = SplitMix64::new(5);
        for n in 1..200 {
            assert!(random.below(n) < n && (0.0..1.0).contains(&random.unit()));
        }
    }
}
