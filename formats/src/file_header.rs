//! The header that `.lodc` and `.lods` files begin with: magic bytes, version and features, and a
//! checksum of the header alone, so that a flipped bit is not taken for a file of another version.

use crate::{Fault, FormatError};

/// Bytes of the magic number.
const MAGIC_BYTES: usize = 8;
/// Features without which a file cannot be read; the other bits are hints. No bit has a meaning
/// yet.
const REQUIRED: u16 = 0x00ff;

/// The header of a format, of which one version exists. It ends with a checksum of `CHECK` bytes.
pub(crate) struct FileHeader<const CHECK: usize> {
    /// What such a file is called in messages.
    pub(crate) name: &'static str,
    /// Not text, not valid UTF-8, and damaged by a transfer that changes line ends.
    pub(crate) magic: [u8; MAGIC_BYTES],
    pub(crate) version: u16,
    /// Bytes of the header.
    pub(crate) length: usize,
    /// Returns the checksum of bytes. Each format has its own algorithm, so that a program that
    /// reads streams alone needs no other.
    pub(crate) checksum: fn(&[u8]) -> [u8; CHECK],
}

impl<const CHECK: usize> FileHeader<CHECK> {
    /// A header without features. Between them and the checksum are zeros: a caller fills them in
    /// and calls [`Self::seal`].
    pub(crate) fn start(&self) -> Vec<u8> {
        let mut header = [&self.magic[..], &self.version.to_le_bytes()].concat();
        header.resize(self.length, 0);
        header
    }

    /// Fills in the checksum of the header that `bytes` begin with.
    pub(crate) fn seal(&self, bytes: &mut [u8]) {
        let (header, checksum) = bytes[..self.length].split_at_mut(self.length - CHECK);
        checksum.copy_from_slice(&(self.checksum)(header));
    }

    /// Checks the header that `bytes` begin with; false if it is cut short.
    pub(crate) fn check(&self, bytes: &[u8]) -> Result<bool, FormatError> {
        let error = |fault, problem: String| Err(FormatError::new(fault, "header", problem));
        let other_format = || error(Fault::Malformed, format!("not a {}", self.name));
        let Some(header) = bytes.get(..self.length) else {
            let length = bytes.len().min(MAGIC_BYTES);
            let is_beginning = bytes[..length] == self.magic[..length];
            return if is_beginning { Ok(false) } else { other_format() };
        };
        let (magic, after_magic) = header.split_at(MAGIC_BYTES);
        let (fields, checksum) = after_magic.split_at(after_magic.len() - CHECK);
        // Of the magic bytes as they should be: where they alone are damaged, the checksum tells
        // that it is a file of this format.
        let checksum_fits = (self.checksum)(&[&self.magic, fields].concat())[..] == *checksum;
        match (magic == self.magic, checksum_fits) {
            (true, true) => {}
            (false, false) => return other_format(),
            _ => return error(Fault::Malformed, "the header is damaged (checksum)".to_owned()),
        }
        let [version, features] =
            [0, 2].map(|offset| u16::from_le_bytes([fields[offset], fields[offset + 1]]));
        let newer = concat!("written by a newer lodc than ", env!("CARGO_PKG_VERSION"));
        let (ours, required) = (self.version, features & REQUIRED);
        match (version, required) {
            (0, _) => error(Fault::Malformed, "there is no version 0".to_owned()),
            (version, 0) if version == ours => Ok(true),
            (version, _) if version == ours => {
                let problem = format!("features {required:#x}: {newer}; this one knows none");
                error(Fault::Unsupported, problem)
            }
            _ => {
                let problem = format!("version {version}: {newer}; this one reads version {ours}");
                error(Fault::Unsupported, problem)
            }
        }
    }
}
