//! What the two local searches of this package share: a seeded random generator, and an exponential
//! for simulated annealing that gives the same bits on every machine.

use lodc_mesh::SplitMix64;

/// Returns the generator of a search with a number. Multiplier (2⁶⁴ over the golden ratio) and
/// offset (chosen by hand, any irregular one does) spread consecutive numbers over all seeds.
pub(crate) fn generator(number: u64) -> SplitMix64 {
    SplitMix64::new(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x2545_f491_4f6c_dd1d)
}

/// A number below `n` from the upper half of 64 random bits.
pub(crate) fn below(bits: u64, n: usize) -> usize {
    (((bits >> 32) * n as u64) >> 32) as usize
}

/// e⁻ˣ for x ≥ 0 to about a thousandth, as e^(−x/4096) by its series, squared twelve times:
/// products and quotients only, which are the same on every machine.
pub(crate) fn exp_minus(x: f64) -> f64 {
    let mut power = 1.0 / (1.0 + x / 4096.0 + x * x / (2.0 * 4096.0 * 4096.0));
    for _ in 0..12 {
        power *= power;
    }
    power
}
