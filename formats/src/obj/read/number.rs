//! Parses numbers in text, correctly rounded.

use std::str::FromStr;

/// The number that a word spells, correctly rounded to `f32` or `f64`, or NaN or infinity; none if
/// it spells none.
pub(super) fn number<T: FromStr + From<f32>>(token: &[u8]) -> Option<T> {
    let standard = std::str::from_utf8(token).ok()?.parse();
    standard.ok().or_else(|| unusual(token))
}

/// The value of a spelling that is in no standard, but found in files.
fn unusual<T: FromStr + From<f32>>(token: &[u8]) -> Option<T> {
    let text = std::str::from_utf8(token).ok()?;
    // A sign before the exponent's letter, `3.1+e2`.
    if let Some(at) =
        text.find(['e', 'E']).filter(|&at| at >= 2 && matches!(token[at - 1], b'+' | b'-'))
    {
        let (mantissa, sign, power) = (&text[..at - 1], &text[at - 1..at], &text[at + 1..]);
        let is_number = !mantissa.is_empty() && power.bytes().all(|b| b.is_ascii_digit());
        return if is_number { format!("{mantissa}e{sign}{power}").parse().ok() } else { None };
    }
    // What some run-time libraries print instead of NaN and infinity: `-nan(ind)`, `1.#QNAN`,
    // `-1.#IND00`, `1.#INF`.
    let lower = text.to_ascii_lowercase();
    let unsigned = lower.trim_start_matches(['-', '+']);
    if unsigned.starts_with("nan(")
        || unsigned.starts_with("1.#qnan")
        || unsigned.starts_with("1.#ind")
    {
        return Some(f32::NAN.into());
    }
    unsigned.starts_with("1.#inf").then(|| f32::INFINITY.into())
}

/// A whole number, with sign; none if there is anything else or it does not fit.
pub(super) fn integer(token: &[u8]) -> Option<i64> {
    let (negative, digits) = match token {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, token),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0i64;
    for b in digits {
        let d = b.wrapping_sub(b'0');
        if d > 9 {
            return None;
        }
        value = value * 10 + i64::from(d);
    }
    Some(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn floats_are_rounded_like_the_standard_library_does() {
        let mut random = Random(7);
        for round in 0..200_000 {
            let bits = random.next();
            let value = f32::from_bits((bits >> 32) as u32);
            let text = match round % 6 {
                0 => format!("{value}"),
                1 => format!("{value:e}"),
                2 => format!("{:.6}", f64::from(value % 1000.0)),
                3 => format!("{}.{}", bits % 100_000, bits >> 40),
                4 => format!("{}e{}", bits >> 12, (bits % 60) as i64 - 30),
                _ => format!("{:.17}", random.unit()),
            };
            let expected: f32 = text.parse().expect(&text);
            let got: f32 = number(text.as_bytes()).expect(&text);
            assert!(
                got.to_bits() == expected.to_bits() || got.is_nan() && expected.is_nan(),
                "{text}: {got}"
            );
        }
    }

    #[test]
    fn values_half_way_between_two_floats_go_to_even() {
        // 16777217 = 2^24 + 1 is half-way; so are these seen through a double rounding.
        for text in [
            "16777217",
            "16777219",
            "1.00000005960464477539062",
            "16777217.0000000001",
            "9007199791611905",
        ] {
            let expected: f32 = text.parse().expect(text);
            assert_eq!(
                number::<f32>(text.as_bytes()).expect(text).to_bits(),
                expected.to_bits(),
                "{text}"
            );
        }
    }

    #[test]
    fn every_way_of_writing_a_number_is_read() {
        for (text, value) in [
            ("+2.", 2.0),
            (".5", 0.5),
            ("-0", -0.0),
            ("2.e1", 20.0),
            ("+1e+2", 100.0),
            ("3.1+e2", 310.0),
            ("3.1-e2", 0.031),
            ("1E2", 100.0),
            ("1e400", f32::INFINITY),
            ("1e-400", 0.0),
            ("1.#INF", f32::INFINITY),
            ("00000000000000000000000001", 1.0),
        ] {
            assert_eq!(
                number::<f32>(text.as_bytes()).map(f32::to_bits),
                Some(f32::to_bits(value)),
                "{text}"
            );
        }
        for text in ["nan", "NaN", "-nan(ind)", "-1.#IND00"] {
            assert!(number(text.as_bytes()).is_some_and(f32::is_nan), "{text}");
        }
        for text in [
            "", "-", "+", ".", "1,5", "0x10", "1e", "e5", "1.2.3", "1_0", "abc", "+e2", "--1",
            "1+e", "\u{661}",
        ] {
            assert_eq!(number::<f32>(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn integers_have_nothing_else_in_them() {
        assert_eq!(integer(b"-12"), Some(-12));
        assert_eq!(integer(b"+7"), Some(7));
        for text in ["", "-", "1.0", "1a", "9999999999999999999"] {
            assert_eq!(integer(text.as_bytes()), None, "{text}");
        }
    }
}
