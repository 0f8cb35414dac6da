//! URIs of buffers and images: `data:` decoded here, everything else a percent-encoded path beside
//! the asset.

use super::json::malformed;
use crate::assets::last_part;
use crate::percent::{percent_decoded, percent_encoded};
use crate::{Assets, Fault, FormatError};

/// The bytes that a buffer's URI stands for. `data:` URIs do not touch the file system; nothing
/// ever touches a network.
pub(crate) fn read(uri: &str, location: &str, assets: &mut Assets) -> Result<Vec<u8>, FormatError> {
    if let Some(after_scheme) = strip_prefix_ignoring_case(uri, "data:") {
        return data(after_scheme, location);
    }
    let Some(path) = path(uri) else {
        let scheme = scheme(uri).unwrap_or_default();
        let problem =
            format!("`{scheme}:` addresses are never read: put the file beside the asset");
        return Err(FormatError::new(Fault::Forbidden, location, problem));
    };
    if strip_prefix_ignoring_case(uri, "file:").is_some() {
        // It leads to a place on another machine: only the name counts.
        let problem = "`file:` addresses are never read: put the file beside the asset";
        let missing = |_| FormatError::new(Fault::Forbidden, location, problem);
        return assets.read_reference(last_part(&path)).map_err(missing);
    }
    match assets.read_name(&path) {
        // A name with a percent sign that happens to decode, or with a query or a place inside the
        // file behind it.
        Err(e) if e.fault == Fault::Unreadable => {
            let address = uri.split(['?', '#']).next().and_then(self::path);
            let others = [Some(uri.to_owned()), address].into_iter().flatten();
            for other in others.filter(|other| *other != path) {
                if let Ok(found) = assets.read_reference(&other) {
                    assets.set_replaced(&path);
                    return Ok(found);
                }
            }
            Err(e)
        }
        other => other,
    }
}

/// The path that a URI stands for, decoded, with `/` between folders: relative or, with a drive or
/// after `file:`, on another machine. A text that does not decode is a path as it is. None for
/// other schemes.
pub(crate) fn path(uri: &str) -> Option<String> {
    let decoded = |text: &str| percent_decoded(text).and_then(|b| String::from_utf8(b).ok());
    let text = match scheme(uri) {
        None => uri,
        Some(drive) if drive.len() == 1 => uri,
        Some(_) => strip_prefix_ignoring_case(uri, "file:")?,
    };
    Some(decoded(text).unwrap_or_else(|| text.to_owned()).replace('\\', "/"))
}

/// A relative path with `/` between folders as a URI.
pub(crate) fn of_path(path: &str) -> String {
    path.split('/').map(percent_encoded).collect::<Vec<_>>().join("/")
}

/// Returns whether a URI carries its own bytes.
pub(crate) fn is_data(uri: &str) -> bool {
    strip_prefix_ignoring_case(uri, "data:").is_some()
}

/// Returns whether a `data:` URI has white space, which means nothing in it.
pub(crate) fn has_white_space(uri: &str) -> bool {
    uri.bytes().any(|b| b.is_ascii_whitespace())
}

fn strip_prefix_ignoring_case<'a>(text: &'a str, prefix: &str) -> Option<&'a str> {
    let head = text.get(..prefix.len())?;
    head.eq_ignore_ascii_case(prefix).then(|| &text[prefix.len()..])
}

fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let mut letters = scheme.bytes();
    let starts = letters.next().is_some_and(|b| b.is_ascii_alphabetic());
    (starts && letters.all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b))).then_some(scheme)
}

/// RFC 2397; a media type of any kind is accepted.
fn data(after_scheme: &str, location: &str) -> Result<Vec<u8>, FormatError> {
    let (header, body) = after_scheme
        .split_once(',')
        .ok_or_else(|| malformed(location, "a data URI without a comma"))?;
    let base64 = header.rsplit(';').next().is_some_and(|last| last.eq_ignore_ascii_case("base64"));
    let bytes = match base64 {
        // Mail and some exporters break long lines.
        true if body.bytes().any(|b| b.is_ascii_whitespace()) => {
            let text: Vec<u8> = body.bytes().filter(|b| !b.is_ascii_whitespace()).collect();
            base64_decoded(&text)
        }
        true => base64_decoded(body.as_bytes()),
        false => percent_decoded(body),
    };
    bytes.ok_or_else(|| malformed(location, "the data URI cannot be decoded"))
}

/// The media type and the bytes of a `data:` URI; none if it is something else or cannot be
/// decoded.
pub(crate) fn decoded_data(uri: &str) -> Option<(String, Vec<u8>)> {
    let after_scheme = strip_prefix_ignoring_case(uri, "data:")?;
    let media_type = after_scheme.split([';', ',']).next()?.to_ascii_lowercase();
    Some((media_type, data(after_scheme, "").ok()?))
}

/// Base 64 of either alphabet (RFC 4648, 4 and 5), padded or not; `None` for anything else.
pub(crate) fn base64_decoded(text: &[u8]) -> Option<Vec<u8>> {
    let end = text.iter().rposition(|&b| b != b'=').map_or(0, |i| i + 1);
    let (body, padding) = text.split_at(end);
    if padding.len() > 2
        || (!padding.is_empty() && !text.len().is_multiple_of(4))
        || body.len() % 4 == 1
    {
        return None;
    }
    let mut out = Vec::with_capacity(body.len() / 4 * 3 + 2);
    for group in body.chunks(4) {
        let mut word = 0u32;
        for &b in group {
            word = word << 6 | sextet(b)?;
        }
        word <<= 6 * (4 - group.len());
        out.extend_from_slice(&word.to_be_bytes()[1..group.len()]);
    }
    Some(out)
}

fn sextet(b: u8) -> Option<u32> {
    Some(u32::from(match b {
        b'A'..=b'Z' => b - b'A',
        b'a'..=b'z' => b - b'a' + 26,
        b'0'..=b'9' => b - b'0' + 52,
        b'+' | b'-' => 62,
        b'/' | b'_' => 63,
        _ => return None,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_every_remainder_decodes_padded_or_not() {
        for (text, bytes) in
            [("", ""), ("TQ==", "M"), ("TWE=", "Ma"), ("TWFu", "Man"), ("TWE", "Ma"), ("TQ", "M")]
        {
            assert_eq!(
                base64_decoded(text.as_bytes()).as_deref(),
                Some(bytes.as_bytes()),
                "{text}"
            );
        }
        assert_eq!(base64_decoded(b"_-8="), base64_decoded(b"/+8="));
    }

    #[test]
    fn what_is_not_base64_is_refused() {
        for text in ["T", "TWFuT", "T===", "TQ=", "TW Fu", "TQ=A", "=", "TWFu\n", "T\u{e9}aa"] {
            assert_eq!(base64_decoded(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn a_data_uri_needs_a_comma_and_sound_base64() {
        assert_eq!(data("application/octet-stream;base64,AQID", "").as_deref(), Ok(&[1, 2, 3][..]));
        assert_eq!(data(",a%00b", "").as_deref(), Ok(&b"a\0b"[..]));
        assert!(data("application/octet-stream;base64", "").is_err());
        assert!(data(";base64,!!!!", "").is_err());
        assert_eq!(data(";base64,AQ\r\n ID\n", "").as_deref(), Ok(&[1, 2, 3][..]));
    }

    #[test]
    fn schemes_are_seen_in_any_case_and_names_with_colons_late_are_not_schemes() {
        assert_eq!(scheme("FILE:///etc/passwd"), Some("FILE"));
        assert_eq!(scheme("http://127.0.0.1/"), Some("http"));
        assert_eq!(scheme("a/b:c"), None);
        assert!(is_data("DATA:,x"));
    }
}
