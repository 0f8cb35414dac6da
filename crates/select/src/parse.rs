//! Parses targets as options and configurations state them: shares and counts of triangles,
//! distances.

use crate::selection::Target;

/// Reads a share of triangles: `25%`, `0.25`, `1`.
///
/// # Errors
/// If it is none.
pub fn share(text: &str) -> Result<f64, String> {
    match size(text) {
        Ok(Target::Ratio(share)) => Ok(share),
        Ok(_) if text == "0" => Ok(0.0),
        Ok(_) => Err("must be a share from 0 to 1, such as 0.25 or 25% (--triangles takes counts)"
            .to_owned()),
        Err(_) => Err("must be a share from 0 to 1, such as 0.25 or 25%".to_owned()),
    }
}

/// Reads a number of triangles: `500`, `10k`, `2m`.
///
/// # Errors
/// If it is none.
pub fn count(text: &str) -> Result<u64, String> {
    match size(text) {
        Ok(Target::Triangles(count)) => Ok(count),
        Ok(_) if text == "1" => Ok(1),
        Ok(_) => Err("must be a count: 500, 10k, 2m (a share is for --ratio)".to_owned()),
        Err(_) => Err("must be a count: 500, 10k, 2m".to_owned()),
    }
}

/// Reads a share or a number of triangles: `25%`, `0.25`, `1` (all), `500`, `10k` or `2m`.
///
/// # Errors
/// If it is neither.
pub fn size(text: &str) -> Result<Target, String> {
    let wrong = || format!("{text}: not a share (25%, 0.25) or a count (500, 10k)");
    let number = |digits: &str| -> Result<f64, String> {
        let value: f64 = digits.parse().map_err(|_| wrong())?;
        if value.is_finite() && value >= 0.0 { Ok(value) } else { Err(wrong()) }
    };
    let ratio = |value: f64| {
        if value <= 1.0 { Ok(Target::Ratio(value)) } else { Err(format!("{text}: above 100 %")) }
    };
    let triangles = |value: f64| Ok(Target::Triangles(value as u64));
    let lower = text.to_lowercase();
    if let Some(percent) = lower.strip_suffix('%') {
        ratio(number(percent)? / 100.0)
    } else if let Some(thousands) = lower.strip_suffix('k') {
        triangles(number(thousands)? * 1e3)
    } else if let Some(millions) = lower.strip_suffix('m') {
        triangles(number(millions)? * 1e6)
    } else if lower.contains(['.', 'e']) || lower == "1" {
        ratio(number(&lower)?)
    } else {
        triangles(number(&lower)?.trunc())
    }
}

/// Reads a bound of the error, as a distance or in percent of the diagonal: `0.5`, `0.5%`.
///
/// # Errors
/// If it is none.
pub fn bound(text: &str) -> Result<Target, String> {
    let (number, percent) = text.strip_suffix('%').map_or((text, false), |number| (number, true));
    let value: f64 = number
        .trim()
        .parse()
        .map_err(|_| "must be a number, such as 0.5, or a percentage, such as 0.5%".to_owned())?;
    if !value.is_finite() || value < 0.0 {
        return Err("a distance of at least 0, or a percentage such as 0.5%".to_owned());
    }
    Ok(if percent { Target::ErrorShare(value / 100.0) } else { Target::Error(value) })
}

/// Reads a bound of the root mean square distance, as [`bound`] does.
///
/// # Errors
/// If it is none.
pub fn rms_bound(text: &str) -> Result<Target, String> {
    Ok(match bound(text)? {
        Target::ErrorShare(share) => Target::RmsShare(share),
        Target::Error(rms) => Target::Rms(rms),
        other => other,
    })
}

#[cfg(test)]
#[path = "parse_tests.rs"]
mod tests;
