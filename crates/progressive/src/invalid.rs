//! The error of a decoder: a stream that no encoder wrote.

/// Why a stream cannot be decoded: a damaged or crafted stream, never one that an encoder wrote.
/// The message follows the name of what is damaged, such as "block 7".
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct InvalidStream(pub &'static str);
