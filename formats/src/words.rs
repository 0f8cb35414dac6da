//! Numbers of things in messages; what stands before text.

/// What some editors write before text in UTF-8.
#[cfg(feature = "import")]
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Text without the mark before it.
#[cfg(feature = "import")]
pub(crate) fn without_mark(text: &[u8]) -> &[u8] {
    text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text)
}

/// A count with its noun, in the singular for one: `1 face`, `1234 faces`.
pub(crate) fn counted(count: impl TryInto<u64>, one: &str, several: &str) -> String {
    match count.try_into().unwrap_or(u64::MAX) {
        1 => format!("1 {one}"),
        count => format!("{count} {several}"),
    }
}
