//! Escapes text and encodes bytes (base64) for HTML pages.

/// Text as HTML shows it.
#[must_use]
pub fn escaped(text: &str) -> String {
    let safe = |c: char| match c {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '"' => "&quot;".to_owned(),
        c => c.to_string(),
    };
    text.chars().map(safe).collect()
}

/// Bytes as text (RFC 4648, section 4).
#[must_use]
pub fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for bytes3 in bytes.chunks(3) {
        let word = bytes3.iter().fold(0, |word, &b| word << 8 | u32::from(b));
        let word = word << (8 * (3 - bytes3.len()));
        for digit in 0..4 {
            let value = word >> (18 - 6 * digit) & 63;
            let character = if digit <= bytes3.len() { DIGITS[value as usize] } else { b'=' };
            out.push(char::from(character));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        let texts = ["", "f", "fo", "foo", "foob", "fooba", "foobar"];
        let wanted = ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"];
        assert_eq!(texts.map(|t| base64(t.as_bytes())), wanted);
    }

    #[test]
    fn nothing_in_escaped_text_is_markup() {
        assert_eq!(escaped("<b a=\"x\">&"), "&lt;b a=&quot;x&quot;&gt;&amp;");
    }
}
