//! Numbers of things in messages.

/// A count with its noun, in the singular for one: `1 face`, `1234 faces`.
pub(crate) fn counted(count: impl TryInto<u64>, one: &str, several: &str) -> String {
    match count.try_into().unwrap_or(u64::MAX) {
        1 => format!("1 {one}"),
        count => format!("{count} {several}"),
    }
}
