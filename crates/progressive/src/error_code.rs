//! The code of a level's error in a stream: the upper 13 bits of the float, rounded up, so that it
//! stays an upper bound and is at most 1/16 too large.

/// Mantissa bits that are left out; the error is rounded up.
const DROPPED_BITS: u32 = 19;

/// Returns the code of an error: the upper 13 bits of the float, rounded up.
pub(crate) fn error_code(error: f32) -> u32 {
    // Adding zero makes +0 of −0.
    ((error + 0.0).to_bits() + (1 << DROPPED_BITS) - 1) >> DROPPED_BITS
}

/// Returns the error of a code: at most 1/16 above the one that was encoded; infinite where no
/// triangle is left.
pub(crate) fn error_value(code: u32) -> f32 {
    let error = f32::from_bits(code << DROPPED_BITS);
    if error.is_nan() { f32::INFINITY } else { error }
}

/// Returns the code of a root mean square distance; that of no number where there is none.
pub(crate) fn rms_code(rms: Option<f32>) -> u32 {
    error_code(rms.unwrap_or(f32::NAN))
}

/// Returns the root mean square distance of a code, if it has one.
pub(crate) fn rms_value(code: u32) -> Option<f32> {
    Some(f32::from_bits(code << DROPPED_BITS)).filter(|rms| !rms.is_nan())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_round_up_and_keep_what_is_no_number() {
        for x in [0.0, 1e-9, 0.75, 3.3, 1e30, f32::INFINITY] {
            let value = error_value(error_code(x));
            assert!(value >= x && value <= x * 1.0625, "{value} for {x}");
            assert_eq!(rms_value(rms_code(Some(x))), Some(value));
        }
        assert_eq!(rms_value(rms_code(None)), None);
    }
}
