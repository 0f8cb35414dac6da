//! The error of a decoder: a stream that no encoder wrote.

use std::error::Error;
use std::fmt;

/// Why a stream cannot be decoded: a damaged or crafted stream, never one that an encoder wrote.
/// The message follows the name of what is damaged, such as "block 7".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InvalidStream(pub &'static str);

impl fmt::Display for InvalidStream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl Error for InvalidStream {}
