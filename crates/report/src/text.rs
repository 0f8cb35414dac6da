//! Formats numbers, sizes, distances and paths for people.

use std::path::Path;

/// Digits in groups of three: `1,234,567`.
#[must_use]
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `1 triangle`, `2,000 triangles`, `3 vertices`, `4 submeshes`.
#[must_use]
pub fn count(n: u64, noun: &str) -> String {
    let plural = match noun.strip_suffix("ex") {
        Some(stem) => format!("{stem}ices"),
        None if noun.ends_with("sh") => format!("{noun}es"),
        None => format!("{noun}s"),
    };
    format!("{} {}", grouped(n), if n == 1 { noun } else { &plural })
}

/// `part` of `whole` in percent; 0 of nothing.
#[must_use]
pub fn percent(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 * 100.0 }
}

/// A number of bytes.
#[must_use]
pub fn size(bytes: u64) -> String {
    match bytes {
        0..1024 => count(bytes, "byte"),
        1024..1_048_576 => format!("{:.1} KiB", bytes as f64 / 1024.0),
        _ => format!("{:.1} MiB", bytes as f64 / 1_048_576.0),
    }
}

/// A distance with four significant digits; without an exponent where that is short.
#[must_use]
pub fn distance(d: f64) -> String {
    if d == 0.0 {
        "0".to_owned()
    } else if d == f64::INFINITY {
        "infinite".to_owned()
    } else if (1e-4..1e5).contains(&d) {
        let decimals = (3.0 - d.log10().floor()).clamp(0.0, 7.0);
        format!("{d:.*}", decimals as usize)
    } else {
        format!("{d:.3e}")
    }
}

/// A path that a shell takes as one word.
#[must_use]
pub fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+,:@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_read_like_english() {
        assert_eq!(count(1, "triangle"), "1 triangle");
        assert_eq!(count(1_234_567, "fake vertex"), "1,234,567 fake vertices");
        assert_eq!(count(2, "submesh"), "2 submeshes");
    }

    #[test]
    fn distances_have_four_digits_that_count() {
        let texts = [0.0, 0.000_123_456, 0.5, 12.345_6, 98_765.4, 1.234_56e-7, 1e9].map(distance);
        assert_eq!(texts, ["0", "0.0001235", "0.5000", "12.35", "98765", "1.235e-7", "1.000e9"]);
    }

    #[test]
    fn a_quoted_path_survives_a_shell() {
        assert_eq!(quoted(Path::new("a b's.lodc")), "'a b'\\''s.lodc'");
        assert_eq!(quoted(Path::new("/x/y-1.lodc")), "/x/y-1.lodc");
    }
}
