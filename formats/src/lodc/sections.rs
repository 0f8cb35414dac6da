//! Finds the byte ranges of arrays in a `.lodc` file, so that an engine can map or upload them
//! without reading the rest.

use super::container::Container;
use super::table::{SCENE, Tag};
use crate::FormatError;

/// A section of a file, its checksum compared. docs/FORMAT.md says what is in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section<'a> {
    /// The kind of its content, such as `TRIS`.
    pub tag: Tag,
    /// The object it belongs to; none if it belongs to the whole scene.
    pub object: Option<u32>,
    /// Its number among those of its tag and object.
    pub index: u32,
    /// True if it is as a device takes it: indices are little-endian `u32`, vertices take a
    /// multiple of four bytes, and it begins at a multiple of 256 bytes of the file.
    pub wide: bool,
    /// Its content. It begins at a multiple of 16 bytes of the file.
    pub bytes: &'a [u8],
}

/// The sections of known kinds of a file, by tag, object and index.
///
/// # Errors
/// If the table or a section is damaged, or the file needs a newer program. What is in the sections
/// is compared with nothing: [`read`](super::read) does that.
pub fn sections(bytes: &[u8]) -> Result<Vec<Section<'_>>, FormatError> {
    Ok(Container::read(bytes)?
        .into_sections()
        .map(|((tag, object, index), section)| Section {
            tag,
            object: (object != SCENE).then_some(object),
            index,
            wide: section.wide,
            bytes: section.bytes,
        })
        .collect())
}
