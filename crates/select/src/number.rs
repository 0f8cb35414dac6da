//! Converts errors to and from the decimals that reports print and people type, so that a printed
//! error selects its own level.

/// The number that the shortest decimal form of an error stands for, as reports print it.
#[must_use]
pub fn decimal(error: f32) -> f64 {
    error.to_string().parse().unwrap_or_else(|_| f64::from(error))
}

/// The error of a level whose vertices are moved by at most `moved`.
#[must_use]
pub fn rounded_error(error: f64, moved: f64) -> f64 {
    error + moved
}

/// The root mean square distance of a level whose vertices move to the corners of a grid, `moved`
/// being half the diagonal of a cell, √3/2 steps. Three coordinates, each off by a uniformly
/// distributed part of a step, have a mean square of a quarter of a step squared.
#[must_use]
pub fn rounded_rms(rms: f64, moved: f64) -> f64 {
    rms.hypot(moved / 3f64.sqrt())
}

/// The largest stored error that, printed and with `rounding`, is at most `error`; negative if none
/// is.
pub(crate) fn threshold(error: f64, rounding: f64) -> f32 {
    let nearest = (error - rounding) as f32;
    let is_above = rounded_error(decimal(nearest), rounding) > error;
    if is_above { nearest.next_down() } else { nearest }
}

/// As [`threshold`], of root mean square distances.
pub(crate) fn rms_threshold(rms: f64, rounding: f64) -> f32 {
    let rounding = rounded_rms(0.0, rounding);
    if rounding > rms {
        return -1.0;
    }
    let nearest = ((rms - rounding) * (rms + rounding)).sqrt() as f32;
    let is_above = decimal(nearest).hypot(rounding) > rms;
    if is_above { nearest.next_down() } else { nearest }
}
