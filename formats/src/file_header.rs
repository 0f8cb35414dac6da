//! The header that both formats begin with: magic bytes, version and features, and a checksum of
//! the header alone, so that a flipped bit is not taken for a file of another version.

use crate::{Fault, FormatError};

/// Bytes of the magic number.
const MAGIC: usize = 8;
/// Features without which a file cannot be read; the other bits are hints. No bit has a meaning
/// yet.
const REQUIRED: u16 = 0x00ff;

/// The header of a format, of which one version exists. It ends with a checksum of `CHECK` bytes.
pub(crate) struct FileHeader<const CHECK: usize> {
    /// What such a file is called in messages.
    pub(crate) name: &'static str,
    /// Not text, not valid UTF-8, and damaged by a transfer that changes line ends.
    pub(crate) magic: [u8; MAGIC],
    pub(crate) version: u16,
    /// Its bytes.
    pub(crate) length: usize,
    /// Returns the checksum of bytes. Each format has one algorithm, so that what reads streams
    /// alone has no other.
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

    /// Makes the checksum right of the header that `bytes` begin with.
    pub(crate) fn seal(&self, bytes: &mut [u8]) {
        let (header, checksum) = bytes[..self.length].split_at_mut(self.length - CHECK);
        checksum.copy_from_slice(&(self.checksum)(header));
    }

    /// Checks the header that `bytes` begin with. Returns whether all of it is there.
    pub(crate) fn check(&self, bytes: &[u8]) -> Result<bool, FormatError> {
        let error = |fault, problem: String| Err(FormatError::new(fault, "header", problem));
        let stranger = || error(Fault::Malformed, format!("this is not a {}", self.name));
        let Some(header) = bytes.get(..self.length) else {
            let some = bytes.len().min(MAGIC);
            return if bytes[..some] == self.magic[..some] { Ok(false) } else { stranger() };
        };
        let (magic, after_magic) = header.split_at(MAGIC);
        let (fields, checksum) = after_magic.split_at(after_magic.len() - CHECK);
        // The magic bytes as they should be: a file of this kind is known by the rest, too.
        let is_sound = (self.checksum)(&[&self.magic, fields].concat())[..] == *checksum;
        match (magic == self.magic, is_sound) {
            (true, true) => {}
            (false, false) => return stranger(),
            _ => return error(Fault::Malformed, "the header is damaged (checksum)".to_owned()),
        }
        let [version, features] = [0, 2].map(|at| u16::from_le_bytes([fields[at], fields[at + 1]]));
        let newer = concat!("written by a newer lodc than ", env!("CARGO_PKG_VERSION"));
        let (known, required) = (self.version, features & REQUIRED);
        match (version, required) {
            (0, _) => error(Fault::Malformed, "there is no version 0".to_owned()),
            (version, 0) if version == known => Ok(true),
            (version, _) if version == known => {
                let problem = format!("features {required:#x}: {newer}; this one knows none");
                error(Fault::Unsupported, problem)
            }
            _ => {
                let problem = format!("version {version}: {newer}; this one reads version {known}");
                error(Fault::Unsupported, problem)
            }
        }
    }
}
