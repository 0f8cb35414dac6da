//! The first block of a stream: source format, number of objects, and the sizes of the document's
//! text and buffer.

use crate::lodc::manifest::{format_code, source_format};
use crate::{Fault, FormatError, SourceFormat};
use lodc_mesh::{put_leb128, take_leb128};

const LOCATION: &str = "head";

/// The sizes of a stream, known before anything else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Head {
    pub(super) format: SourceFormat,
    /// Number of objects.
    pub(super) objects: u32,
    /// Bytes of the document's text.
    pub(super) text: u32,
    /// Bytes of the text as it is stored: fewer if it is coded.
    pub(super) stored: u32,
    /// Bytes of buffer 0 of a glTF.
    pub(super) buffer: u64,
}

impl Head {
    /// Returns the payload of the block.
    pub(super) fn to_bytes(self) -> Vec<u8> {
        let mut out = vec![format_code(self.format)];
        for n in [u64::from(self.objects), self.text.into(), self.stored.into(), self.buffer] {
            put_leb128(&mut out, n);
        }
        out
    }

    /// Parses the payload of the block.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let malformed = |problem: &str| FormatError::new(Fault::Malformed, LOCATION, problem);
        let (&format, mut unread) = bytes.split_first().ok_or_else(|| malformed("is empty"))?;
        let format = source_format(format).map_err(|problem| malformed(&problem))?;
        let mut number = |max: u64| {
            take_leb128(&mut unread, max).ok_or_else(|| malformed("has an invalid number"))
        };
        let u32_max = u64::from(u32::MAX);
        let (objects, text, stored) = (number(u32_max)?, number(u32_max)?, number(u32_max)?);
        let buffer = number(u64::MAX)?;
        if stored > text || !format.is_gltf() && buffer > 0 {
            return Err(malformed("announces a document of an invalid size"));
        }
        if !unread.is_empty() {
            return Err(malformed("has extra bytes at its end"));
        }
        let [objects, text, stored] = [objects, text, stored].map(|n| n as u32);
        Ok(Self { format, objects, text, stored, buffer })
    }
}
