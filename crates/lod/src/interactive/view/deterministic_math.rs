//! Arithmetic that gives the same bits on every graphics device and on the CPU: additions and
//! multiplications of `f32` in a fixed order, and operations on bits.
//!
//! Division, square roots and trigonometry are only approximately fixed by WGSL, and its compilers
//! may rearrange what they can see through. So the kernels use these functions, with every result
//! passed through a barrier.

/// One over the square root of a positive normal number, to about 17 bits: two steps of Newton's
/// method from the usual estimate by bits.
#[must_use]
pub fn rsqrt(x: f32) -> f32 {
    let mut y = f32::from_bits(0x5f37_59df - (x.to_bits() >> 1));
    let half = 0.5 * x;
    for _ in 0..2 {
        let square = half * y * y;
        y *= 1.5 - square;
    }
    y
}

/// Dot product, first component first.
#[must_use]
pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The largest power of two that is not larger than one over a positive number: scaling by it is
/// exact.
#[must_use]
pub fn inverse_power(x: f64) -> f32 {
    let mut power = 1.0f32;
    while f64::from(power) * x > 1.0 && power > 1e-30 {
        power *= 0.5;
    }
    while f64::from(power) * x * 2.0 <= 1.0 && power < 1e30 {
        power *= 2.0;
    }
    power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_near_the_true_one() {
        for i in 1..10_000u32 {
            let x = i as f32 * 0.37 * f32::from_bits((100 + i % 55) << 23);
            let y = f64::from(rsqrt(x));
            assert!((y * f64::from(x).sqrt() - 1.0).abs() < 5e-6, "{x}");
        }
    }

    #[test]
    fn powers_are_the_nearest_below() {
        for (x, power) in [(1.0, 1.0), (3.0, 0.25), (0.3, 2.0), (1000.0, 1.0 / 1024.0)] {
            assert_eq!(inverse_power(x), power);
        }
    }
}
