//! Errors in decimal, as reports print them and people type them, converted so that a printed error
//! selects its own level.

/// An error as the number that its shortest decimal form stands for: what reports print and people
/// type.
#[must_use]
pub fn decimal(error: f32) -> f64 {
    error.to_string().parse().unwrap_or_else(|_| f64::from(error))
}

/// The largest stored error that, printed, is at most `error`.
pub(crate) fn threshold(error: f64) -> f32 {
    let nearest = error as f32;
    if decimal(nearest) > error { nearest.next_down() } else { nearest }
}
