//! Squared distances in a byte, to compare them and to weigh samples by.

/// A squared distance, to within a fifth, from 2⁻⁵⁸ to 16 in units of the input; less is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct RoughSquare(u8);

impl RoughSquare {
    pub(crate) const ZERO: Self = Self(0);

    /// The bits of the exponent and the first two of the mantissa, from 2⁻⁵⁹ on.
    const FIRST: u32 = (127 - 59) << 2;

    pub(crate) fn new(squared: f32) -> Self {
        let bits = squared.to_bits() >> 21;
        Self(bits.saturating_sub(Self::FIRST).min(255) as u8)
    }

    pub(crate) fn get(self) -> f32 {
        match self {
            Self::ZERO => 0.0,
            Self(code) => f32::from_bits((u32::from(code) + Self::FIRST) << 21 | 1 << 20),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_tells_a_squared_distance_to_within_a_fifth() {
        for squared in [16.0f32, 1.0, 0.37, 1e-9, 3e-17] {
            let rough = RoughSquare::new(squared).get();
            assert!((rough / squared - 1.0).abs() < 0.2, "{squared} {rough}");
        }
        assert_eq!([0.0, 1e-19].map(|s| RoughSquare::new(s).get()), [0.0; 2]);
        assert!(RoughSquare::new(f32::MAX).get() > 10.0);
    }
}
