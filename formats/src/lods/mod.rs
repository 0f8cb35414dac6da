//! The `.lods` container, version 7 (docs/STREAM.md): progressive streams as checksummed blocks.
//!
//! [`pack()`] writes a stream; an [`Unpacker`] is fed one piece by piece and shows the mesh of
//! every prefix. What the blocks say is `lodc_progressive`'s concern; this folder has the blocks,
//! the headers of objects, the document, which is everything but the meshes, and the order in which
//! objects and the document take turns.

mod arrived;
mod block;
mod document;
mod head;
mod object_header;
mod old;
mod pack;
mod rebuild;
mod received;
#[cfg(test)]
mod tests;
mod unpack;

pub use arrived::Arrived;
pub use document::SequenceFacts;
pub use lodc_progressive::{ErrorBound, Quantize};
pub use pack::{PackOptions, Packed, PackedObject, pack};
pub use rebuild::Rebuilt;
pub use unpack::{Progress, Unpacker};

/// The version that this program writes unless a mesh needs a later one. Versions have an odd
/// number of set bits, so that one flipped bit makes no version of another: 1, 2, 4, 7, 8, 11, …
pub const VERSION: u32 = 7;

/// The version of streams of which some vertices repeat the target of their parent, so that stars
/// of thousands of triangles are not coded time and again.
pub const HUB_VERSION: u32 = 8;

/// The version of streams that name what is transferred of such stars, as there are too many splits
/// of them that transfer something. The newest that this program reads.
pub const NAMING_VERSION: u32 = 11;

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
    let mut out = bytes[..bytes.len().min(block::PREAMBLE)].to_vec();
    let mut rest = &bytes[out.len()..];
    for number in 0.. {
        let Some((block, length)) = block::parse_unchecked(rest) else { break };
        block::put(&mut out, number, block);
        rest = &rest[length..];
    }
    out
}
