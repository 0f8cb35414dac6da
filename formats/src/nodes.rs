//! Numbers in a glTF document.

use serde_json::Value;

/// An index into one of the document's lists.
pub(crate) fn as_index(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|i| usize::try_from(i).ok())
}

/// As many numbers as there should be, or the default.
pub(crate) fn numbers<const N: usize>(value: &Value, default: [f64; N]) -> [f64; N] {
    match value.as_array() {
        Some(a) if a.len() == N => std::array::from_fn(|i| a[i].as_f64().unwrap_or(default[i])),
        _ => default,
    }
}
