//! STL.

/// Bytes of the text that a binary file begins with; the number of facets follows.
const TEXT_BYTES: usize = 80;
/// Bytes of a facet of a binary file: normal, three corners, two bytes of attributes.
const FACET_BYTES: usize = 50;

#[cfg(feature = "import")]
pub(crate) mod read;
#[cfg(feature = "export")]
pub(crate) mod write;
