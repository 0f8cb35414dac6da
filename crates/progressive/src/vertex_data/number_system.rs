//! Number systems: rising lists of floats; a value is coded as its index in the list of its
//! channel.
//!
//! Floats that came from text are few of all floats. Predictions are made in floats and residuals
//! are distances in the list, so a number with six decimal digits costs what six digits are worth,
//! not the 24 bits of its mantissa. Lossless: a system is used for a stream only if it holds every
//! value of the stream, bit for bit.

/// A rising list of floats, indexed from the one at or above zero; −0 has index −1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NumberSystem {
    /// All floats in the order of their bits, NaNs outermost.
    Float,
    /// Multiples of 10^−n, n up to 9.
    Decimal(u8),
    /// Numbers with n significant decimal digits, n from 1 to 7.
    Significant(u8),
    /// Integers: the index is the value itself.
    Integer,
    /// `origin + i * step`: a quantisation grid.
    Grid {
        /// The float at index 0.
        origin: f32,
        /// The distance between neighbours, above 0.
        step: f32,
    },
}

/// One below the decade (decimal exponent) of the smallest float, about 1.4 × 10^−45.
const LEAST_DECADE: i32 = -46;

/// The powers of ten that are exact in `f64`.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// The smallest integer with n decimal digits; entry 0 only makes masked accesses safe.
const SMALLEST_WITH_DIGITS: [i32; 8] = [1, 1, 10, 100, 1_000, 10_000, 100_000, 1_000_000];

/// Powers of ten from 0 to 66, each a product of up to three of [`EXACT_POWERS`].
const POWERS_OF_TEN: [f64; 67] = {
    let mut powers = [1.0; 67];
    let mut n = 0;
    while n < powers.len() {
        let (a, b) = if n > 44 {
            (22, 22)
        } else if n > 22 {
            (22, n - 22)
        } else {
            (n, 0)
        };
        powers[n] = EXACT_POWERS[a] * EXACT_POWERS[b] * EXACT_POWERS[n - a - b];
        n += 1;
    }
    powers
};

/// Returns `m * 10^exponent`: correctly rounded for all but the largest exponents, and the same on
/// every machine for those.
#[inline]
fn scaled(m: f64, exponent: i32) -> f64 {
    let power = POWERS_OF_TEN[exponent.unsigned_abs().min(66) as usize];
    if exponent >= 0 { m * power } else { m / power }
}

impl NumberSystem {
    /// Returns the index of the float in the list that is nearest to `value`.
    #[inline]
    #[must_use]
    pub fn index(self, value: f32) -> i32 {
        match self {
            Self::Float => {
                let bits = value.to_bits() as i32;
                if bits >= 0 { bits } else { -1 - (bits & i32::MAX) }
            }
            Self::Decimal(digits) => {
                let scale = EXACT_POWERS[usize::from(digits)];
                signed_index(value, |v| (v * scale + 0.5) as i32)
            }
            Self::Significant(digits) => {
                signed_index(value, |v| significant_index(v, i32::from(digits)))
            }
            Self::Integer => value as i32,
            Self::Grid { origin, step } => {
                ((f64::from(value) - f64::from(origin)) / f64::from(step) + 0.5).floor() as i32
            }
        }
    }

    /// Returns the float at an index.
    #[inline]
    #[must_use]
    pub fn value(self, index: i32) -> f32 {
        // Not `-index`, so that −1 is −0.
        let magnitude = if index < 0 { !index } else { index };
        let value = match self {
            Self::Float => {
                return if index >= 0 {
                    f32::from_bits(index as u32)
                } else {
                    f32::from_bits(magnitude as u32 | 1 << 31)
                };
            }
            Self::Integer => return index as f32,
            Self::Grid { origin, step } => {
                return (f64::from(origin) + f64::from(index) * f64::from(step)) as f32;
            }
            Self::Decimal(digits) => f64::from(magnitude) / EXACT_POWERS[usize::from(digits)],
            Self::Significant(_) if magnitude == 0 => 0.0,
            Self::Significant(digits) => {
                let first = SMALLEST_WITH_DIGITS[usize::from(digits & 7)];
                let (decade, rest) = ((magnitude - 1) / (9 * first), (magnitude - 1) % (9 * first));
                scaled(f64::from(first + rest), decade + LEAST_DECADE + 1 - i32::from(digits))
            }
        };
        let value = value as f32;
        if index < 0 { -value } else { value }
    }

    /// Returns whether the floats from index `lowest` to `highest` are known to be evenly spaced,
    /// so that their mean is the mean of the indices. Spacing changes at powers of two in
    /// [`Self::Float`] and at powers of ten in [`Self::Significant`].
    #[inline]
    pub(crate) fn is_evenly_spaced(self, lowest: i32, highest: i32) -> bool {
        match self {
            Self::Float => lowest >> 23 == highest >> 23,
            Self::Significant(digits) => {
                let decade_size = 9 * SMALLEST_WITH_DIGITS[usize::from(digits & 7)];
                let decade = |n: i32| (if n < 0 { !n } else { n } - 1) / decade_size;
                (lowest > 0 || highest < -1) && decade(lowest) == decade(highest)
            }
            _ => true,
        }
    }

    /// Returns whether all neighbours are the same distance apart, except −0 and 0.
    pub(crate) fn has_fixed_step(self) -> bool {
        matches!(self, Self::Decimal(_) | Self::Integer | Self::Grid { .. })
    }

    /// Returns whether the list holds this float, bit for bit.
    #[must_use]
    pub fn contains(self, value: f32) -> bool {
        self.value(self.index(value)).to_bits() == value.to_bits()
    }

    /// Returns the systems that hold all of the values; [`Self::Float`] is always one.
    pub(crate) fn candidates(values: &(impl Iterator<Item = f32> + Clone)) -> Vec<Self> {
        let holds_all = |s: &Self| values.clone().all(|v| s.contains(v));
        let decimal = (0..=9).map(Self::Decimal).find(holds_all);
        let significant = (1..=7).map(Self::Significant).find(holds_all);
        [Some(Self::Float), decimal, significant].into_iter().flatten().collect()
    }
}

/// Returns the index of a float, given a function for the index of its magnitude. −0 has an index
/// of its own, −1.
fn signed_index(value: f32, magnitude_index: impl Fn(f64) -> i32) -> i32 {
    // NaN is in no list of decimals, but a prediction may be NaN: any index will do that is the
    // same on every machine.
    if value.is_nan() {
        return 0;
    }
    let magnitude = magnitude_index(f64::from(value.abs()));
    if value.is_sign_negative() { !magnitude } else { magnitude }
}

/// Returns the index of a magnitude among the numbers with `digits` significant digits.
fn significant_index(value: f64, digits: i32) -> i32 {
    if value == 0.0 {
        return 0;
    }
    let value = value.min(f64::from(f32::MAX));
    // An estimate of the decade from the binary exponent (1233 / 4096 is about log10 2), then
    // corrected by one.
    let exponent = (value.to_bits() >> 52) as i32 - 1023;
    let mut decade = (exponent * 1233) >> 12;
    if scaled(1.0, decade + 1) <= value {
        decade += 1;
    } else if scaled(1.0, decade) > value {
        decade -= 1;
    }
    let first = SMALLEST_WITH_DIGITS[digits as usize & 7];
    let unit = decade + 1 - digits;
    let mut mantissa = (scaled(value, -unit) + 0.5) as i32;
    if mantissa >= 10 * first {
        mantissa = first;
        decade += 1;
    }
    (decade - LEAST_DECADE) * 9 * first + mantissa.max(first) - first + 1
}

/// Rounds half up, into the range of an i32; NaN becomes 0.
#[inline]
pub(crate) fn round_half_up(x: f64) -> i32 {
    (x + 0.5).floor() as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_mesh::SplitMix64;

    const SYSTEMS: [NumberSystem; 7] = [
        NumberSystem::Float,
        NumberSystem::Decimal(0),
        NumberSystem::Decimal(6),
        NumberSystem::Significant(1),
        NumberSystem::Significant(6),
        NumberSystem::Significant(7),
        NumberSystem::Integer,
    ];

    #[test]
    fn indices_lead_to_floats_and_back() {
        let mut random = SplitMix64::new(1);
        for system in SYSTEMS {
            for _ in 0..20_000 {
                let index = random.bits() as i32 >> random.below(31);
                // Reduced to where neighbours are different floats and none is infinite.
                let index = match system {
                    NumberSystem::Float => index >> 1,
                    NumberSystem::Significant(n) => index % (80 * 9 * 10i32.pow(u32::from(n) - 1)),
                    _ => index % 0xff_ffff,
                };
                let value = system.value(index);
                assert!(system.contains(value), "{system:?} {index} {value:e}");
                assert!(system.value(index + 1) >= value, "{system:?} does not rise at {index}");
            }
        }
    }

    #[test]
    fn numbers_from_text_are_recognised() {
        let candidates = |texts: &[&str]| {
            let values: Vec<f32> = texts.iter().map(|t| t.parse().expect("a number")).collect();
            NumberSystem::candidates(&values.into_iter())
        };
        assert_eq!(
            candidates(&["0.25", "-1.50", "-0", "3"]),
            [NumberSystem::Float, NumberSystem::Decimal(2), NumberSystem::Significant(2)]
        );
        assert_eq!(
            candidates(&["0.0378297", "0.00447467", "-1.55991e-08"]),
            [NumberSystem::Float, NumberSystem::Significant(6)]
        );
        assert_eq!(candidates(&["0.123456789", "1e30"]), [NumberSystem::Float]);
        assert_eq!(candidates(&["NaN", "1"]), [NumberSystem::Float]);
    }

    #[test]
    fn any_value_has_a_nearest_index() {
        for value in [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            f32::MIN,
            f32::MIN_POSITIVE,
            1e-45,
            -0.0,
        ] {
            for system in SYSTEMS {
                let _ = system.value(system.index(value));
            }
        }
    }
}
