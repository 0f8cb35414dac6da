//! Percent-encoding of names in addresses (RFC 3986, 2.1).

/// `%XX` turned into bytes; `None` where a `%` is not followed by two hexadecimal digits.
pub(crate) fn percent_decoded(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len());
    let mut bytes = text.bytes();
    while let Some(b) = bytes.next() {
        if b == b'%' {
            let mut digit = || char::from(bytes.next()?).to_digit(16);
            let value = digit()? * 16 + digit()?;
            out.push(value as u8);
        } else {
            out.push(b);
        }
    }
    Some(out)
}

/// A file name as a URI: everything but unreserved characters percent-encoded.
pub(crate) fn percent_encoded(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    for b in name.bytes() {
        if b.is_ascii_alphanumeric() || b"-._~".contains(&b) {
            out.push(char::from(b));
        } else {
            out.push_str(&format!("%{b:02X}"));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_encoding_goes_both_ways() {
        let name = "Unicode ❤♻ %41.bin";
        assert_eq!(percent_decoded(&percent_encoded(name)).as_deref(), Some(name.as_bytes()));
        assert_eq!(percent_decoded("%4"), None);
        assert_eq!(percent_decoded("%+1"), None);
    }
}
