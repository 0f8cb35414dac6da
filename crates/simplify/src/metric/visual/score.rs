//! Scores of a mesh in a picture, one number per view, from the pixels that each face covers.
//!
//! Viewpoint entropy (Vázquez et al. 2001): `H = log₂ N − (1/N) Σ f(aᵢ)` with `f(a) = a log₂ a`
//! over all faces and the background: item `i` covers `aᵢ` of `N` pixels. Kullback–Leibler
//! divergence of visible areas from areas in space (Castelló et al.): `KL = (1/a) Σ aᵢ log₂(aᵢ/Aᵢ)
//! − log₂ a + log₂ A` over all faces, where face `i` has the area `Aᵢ` in space, and `a` and `A`
//! are the sums. Both change by a sum over the faces that change.

/// The kind of score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Score {
    /// Viewpoint entropy.
    Entropy,
    /// Kullback–Leibler divergence.
    Divergence,
}

/// `f(a) = a log₂ a` of every number of pixels.
pub(super) struct Table(Vec<f64>);

impl Table {
    pub(super) fn new(pixels: usize) -> Self {
        Self((0..=pixels).map(|a| if a == 0 { 0.0 } else { a as f64 * log2(a as f64) }).collect())
    }

    #[inline]
    pub(super) fn at(&self, pixels: u32) -> f64 {
        self.0[pixels as usize]
    }
}

/// Binary logarithm of a positive number, the same on every machine: no library is asked.
fn log2(x: f64) -> f64 {
    let bits = x.to_bits();
    let mut exponent = ((bits >> 52) & 0x7ff) as i32 - 1023;
    let mut mantissa = f64::from_bits(bits & 0x000f_ffff_ffff_ffff | 0x3ff0_0000_0000_0000);
    if mantissa > std::f64::consts::SQRT_2 {
        mantissa *= 0.5;
        exponent += 1;
    }
    // ln m = 2 artanh t; with |t| < 0.172 ten terms leave less than the last bit.
    let t = (mantissa - 1.0) / (mantissa + 1.0);
    let mut series = 0.0;
    for k in (0..=10).rev() {
        series = series * t * t + 1.0 / f64::from(2 * k + 1);
    }
    f64::from(exponent) + 2.0 * t * series * std::f64::consts::LOG2_E
}

/// Binary logarithm of an area; areas below 1e-30, zero among them, count as that.
pub(super) fn log_area(area: f64) -> f64 {
    log2(area.max(1e-30))
}

#[cfg(test)]
mod tests {
    use super::log2;

    #[test]
    fn logarithms_are_those_of_the_library() {
        for i in 1..100_000u32 {
            for x in [f64::from(i), 1.0 / f64::from(i), f64::from(i) * 1e-30] {
                assert!((log2(x) - x.log2()).abs() <= 1e-14 * x.log2().abs().max(1.0), "{x}");
            }
        }
        assert!((0..1023).all(|e| log2(f64::from(e).exp2()) == f64::from(e)));
    }
}
