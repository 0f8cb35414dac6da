//! Numbers in text, correctly rounded.

/// A number of a file: tobj reads it as it stands, or as its value if only this package knows the
/// spelling.
#[derive(Clone, Copy, Debug)]
pub(super) enum Number<'a> {
    /// Digits with at most a sign and a point, few enough to be finite: read by nobody yet.
    Plain(&'a [u8]),
    /// Anything else that [`str::parse`] takes, with its value.
    Other(&'a [u8], f32),
    /// A spelling that is not in any standard.
    Unusual(f32),
}

impl<'a> Number<'a> {
    /// Zero.
    pub(super) const ZERO: Self = Self::Plain(b"0");

    /// The number that a word is; `nan` and `inf` in any case are numbers too.
    pub(super) fn new(token: &'a [u8]) -> Option<Self> {
        if is_plain(token) {
            return Some(Self::Plain(token));
        }
        let standard = std::str::from_utf8(token).ok()?.parse();
        standard.map_or_else(
            |_| unusual(token).map(Self::Unusual),
            |value| Some(Self::Other(token, value)),
        )
    }

    /// Its value, correctly rounded.
    pub(super) fn value(&self) -> f32 {
        match *self {
            Self::Plain(token) => {
                let value = std::str::from_utf8(token).ok().and_then(|text| text.parse().ok());
                value.expect("plain digits are a number")
            }
            Self::Other(_, value) | Self::Unusual(value) => value,
        }
    }

    /// Returns whether it is neither infinite nor NaN.
    pub(super) fn is_finite(&self) -> bool {
        matches!(self, Self::Plain(_)) || self.value().is_finite()
    }

    /// Appends a spelling that reads back as the same value.
    pub(super) fn write(&self, text: &mut Vec<u8>) {
        match *self {
            Self::Plain(token) | Self::Other(token, _) => text.extend_from_slice(token),
            Self::Unusual(value) => text.extend_from_slice(value.to_string().as_bytes()),
        }
    }
}

fn is_plain(token: &[u8]) -> bool {
    let digits = match token {
        [b'-' | b'+', rest @ ..] => rest,
        _ => token,
    };
    let (mut count, mut points) = (0, 0);
    for b in digits {
        match b {
            b'0'..=b'9' => count += 1,
            b'.' => points += 1,
            _ => return false,
        }
    }
    // The largest f32 has 39 digits.
    (1..=38).contains(&count) && points <= 1
}

/// The value of a spelling that is in no standard but in files.
fn unusual(token: &[u8]) -> Option<f32> {
    let text = std::str::from_utf8(token).ok()?;
    // A sign that stands before the exponent's letter, `3.1+e2`.
    if let Some(at) =
        text.find(['e', 'E']).filter(|&at| at >= 2 && matches!(token[at - 1], b'+' | b'-'))
    {
        let (mantissa, sign, power) = (&text[..at - 1], &text[at - 1..at], &text[at + 1..]);
        let plain = !mantissa.is_empty() && power.bytes().all(|b| b.is_ascii_digit());
        return if plain { format!("{mantissa}e{sign}{power}").parse().ok() } else { None };
    }
    // What some run-time libraries print instead of NaN and infinity: `-nan(ind)`, `1.#QNAN`,
    // `-1.#IND00`, `1.#INF`.
    let lower = text.to_ascii_lowercase();
    let unsigned = lower.trim_start_matches(['-', '+']);
    if unsigned.starts_with("nan(")
        || unsigned.starts_with("1.#qnan")
        || unsigned.starts_with("1.#ind")
    {
        return Some(f32::NAN);
    }
    unsigned.starts_with("1.#inf").then_some(f32::INFINITY)
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

    /// The value that tobj reads, which is also the one that the guard knows.
    fn float(token: &[u8]) -> Option<f32> {
        let number = Number::new(token)?;
        let mut written = Vec::new();
        number.write(&mut written);
        let text = String::from_utf8(written).expect("ASCII");
        let value: f32 = text.parse().expect("as the standard library reads it");
        let known = number.value();
        assert!(known.to_bits() == value.to_bits() || known.is_nan() && value.is_nan(), "{text}");
        assert_eq!(number.is_finite(), value.is_finite(), "{text}");
        Some(value)
    }

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
            let got = float(text.as_bytes()).expect(&text);
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
            assert_eq!(float(text.as_bytes()).expect(text).to_bits(), expected.to_bits(), "{text}");
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
                float(text.as_bytes()).map(f32::to_bits),
                Some(f32::to_bits(value)),
                "{text}"
            );
        }
        for text in ["nan", "NaN", "-nan(ind)", "-1.#IND00"] {
            assert!(float(text.as_bytes()).is_some_and(f32::is_nan), "{text}");
        }
        for text in [
            "", "-", "+", ".", "1,5", "0x10", "1e", "e5", "1.2.3", "1_0", "abc", "+e2", "--1",
            "1+e", "\u{661}",
        ] {
            assert_eq!(float(text.as_bytes()), None, "{text}");
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
