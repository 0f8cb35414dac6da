//! The codes of a level's two errors in a stream, the upper bound and the root mean square: the
//! upper 13 bits of the float, rounded up, so that an upper bound stays one and is at most 1/16 too
//! large.

/// Low mantissa bits that are dropped: 4 of 23 remain. A constant of the format.
const DROPPED_BITS: u32 = 19;

/// The codes of the two errors of a level: the upper bound and the root mean square distance. Zero
/// for an object without vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ErrorCodes {
    pub(crate) error: u32,
    pub(crate) rms: u32,
}

impl ErrorCodes {
    /// The codes before the first batch ends: an infinite error, and no distance.
    pub(crate) const UNKNOWN: Self = Self { error: 0xfff, rms: 0xfff };
}

/// Returns the code of an error: the upper 13 bits of the float, rounded up.
pub(crate) fn error_code(error: f32) -> u32 {
    // Adding zero turns −0 into +0.
    ((error + 0.0).to_bits() + (1 << DROPPED_BITS) - 1) >> DROPPED_BITS
}

/// Returns the error of a code: at most 1/16 above the one that was encoded; infinite at a level
/// without triangles.
pub(crate) fn error_value(code: u32) -> f32 {
    let error = f32::from_bits(code << DROPPED_BITS);
    if error.is_nan() { f32::INFINITY } else { error }
}

/// Returns the code of a root mean square distance; the code of NaN if it was not measured.
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
    fn codes_round_up_and_keep_nan() {
        for x in [0.0, 1e-9, 0.75, 3.3, 1e30, f32::INFINITY] {
            let value = error_value(error_code(x));
            assert!(value >= x && value <= x * 1.0625, "{value} for {x}");
            assert_eq!(rms_value(rms_code(Some(x))), Some(value));
        }
        assert_eq!(rms_value(rms_code(None)), None);
        let ErrorCodes { error, rms } = ErrorCodes::UNKNOWN;
        assert_eq!((error_value(error), rms_value(rms)), (f32::INFINITY, None));
        assert!(error >= error_code(f32::INFINITY) && rms >= rms_code(None), "codes only fall");
    }
}
