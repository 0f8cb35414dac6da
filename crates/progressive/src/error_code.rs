//! The error after a step, as a stream codes it: the upper bits of the float.

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
