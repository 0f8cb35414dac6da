//! Converts errors to and from the decimals that reports print and people type, so that a printed
//! error selects its own level.

/// The number that the shortest decimal form of an error stands for, as reports print it.
#[must_use]
pub fn decimal(error: f32) -> f64 {
    error.to_string().parse().unwrap_or_else(|_| f64::from(error))
}

/// The largest stored error that, printed, is at most `error`.
pub(crate) fn threshold(error: f64) -> f32 {
    let nearest = error as f32;
    if decimal(nearest) > error { nearest.next_down() } else { nearest }
}
