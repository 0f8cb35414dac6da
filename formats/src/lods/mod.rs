//! The `.lods` container (docs/STREAM.md): progressive streams as checksummed blocks.
//!
//! [`pack()`] writes a stream; an [`Unpacker`] is fed one piece by piece and shows the mesh of
//! every prefix. What the blocks say is `lodc_progressive`'s concern; this folder has the blocks,
//! the headers of objects, the document, which is everything but the meshes, and the order in which
//! objects and the document take turns.

mod arrived;
mod block;
mod document;
mod head;
mod mesh_header;
mod pack;
mod rebuild;
mod received;
#[cfg(test)]
mod tests;
mod unpack;

pub use arrived::Arrived;
pub use document::SequenceFacts;
pub use lodc_progressive::{ErrorBound, Quantize, StepOrder, in_batches};
pub use pack::{PackOptions, Packed, PackedObject, pack};
pub use rebuild::{Rebuilt, as_streamed};
pub use unpack::{Progress, Unpacker};

/// The version of the format.
pub const VERSION: u16 = 1;

/// Returns whether bytes claim to be a `.lods` stream.
#[must_use]
pub fn is_lods(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89LODS")
}

/// Returns the bytes with the checksums that they should have as a stream: for tests with forged
/// streams, and for fuzzing.
#[doc(hidden)]
#[must_use]
pub fn with_valid_checksums(bytes: &[u8]) -> Vec<u8> {
    let header = block::FILE_HEADER.length;
    let mut out = bytes[..bytes.len().min(header)].to_vec();
    if out.len() == header {
        block::FILE_HEADER.seal(&mut out);
    }
    let mut rest = &bytes[out.len()..];
    for number in 0.. {
        let Some((block, length)) = block::parse_unchecked(rest) else { break };
        block::put(&mut out, number, block);
        rest = &rest[length..];
    }
    out
}
