//! Blocks of a `.lods` stream: a header (tag, number of steps, length), its checksum, the payload
//! and its checksum, so that a reader can use each block as soon as it has arrived.

use super::VERSION;
use crate::file_header::FileHeader;
use lodc_mesh::{put_leb128, take_leb128};
use xxhash_rust::xxh32::xxh32;

/// The bytes before the first block.
pub(super) const FILE_HEADER: FileHeader<4> = FileHeader {
    name: ".lods stream",
    magic: *b"\x89LODS\r\n\x1a",
    version: VERSION,
    length: 16,
    checksum: |header| xxh32(header, 0).to_le_bytes(),
};
/// Largest number of bytes in a payload; only that of the first block may be longer. Chosen by
/// hand, to bound what a reader keeps of an unfinished block.
pub(super) const MAX_PAYLOAD: usize = 16 << 20;
/// Bytes of the checksum of a block's header: the low ones of an XXH32.
const HEADER_CHECKSUM_BYTES: usize = 2;
/// Bytes of the checksum of a payload: an XXH32.
const PAYLOAD_CHECKSUM_BYTES: usize = 4;

/// A block whose checksums are right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Block<'a> {
    /// 0: the head, a piece of the document, the end of the stream, or, with steps, those of
    /// objects that take turns; else one more than the number of an object.
    pub(super) tag: u32,
    /// Number of refinement steps in the payload.
    pub(super) steps: u32,
    /// Encoded steps, or a piece of the document.
    pub(super) payload: &'a [u8],
}

/// The result of parsing a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parsed<'a> {
    /// A block, and its total length in bytes.
    Block(Block<'a>, usize),
    /// The beginning of a block.
    Incomplete,
    /// No block.
    Damaged(&'static str),
}

/// Appends a block. `number` counts the blocks of a stream; its low 32 bits are a seed.
pub(super) fn put(out: &mut Vec<u8>, number: u64, block: Block<'_>) {
    let start = out.len();
    for n in [block.payload.len() as u32, block.tag, block.steps] {
        put_leb128(out, u64::from(n));
    }
    let header_checksum = xxh32(&out[start..], number as u32);
    out.extend_from_slice(&header_checksum.to_le_bytes()[..HEADER_CHECKSUM_BYTES]);
    out.extend_from_slice(&xxh32(block.payload, header_checksum).to_le_bytes());
    out.extend_from_slice(block.payload);
}

/// Parses block `number` from the beginning of `bytes`.
pub(super) fn parse(bytes: &[u8], number: u64) -> Parsed<'_> {
    let (fields_end, [length, tag, steps]) = match parse_fields(bytes) {
        Fields::Complete(fields_end, fields) => (fields_end, fields),
        Fields::Incomplete => return Parsed::Incomplete,
        Fields::Invalid => {
            return Parsed::Damaged("has a number that is not written as it should be");
        }
    };
    let header_checksum = xxh32(&bytes[..fields_end], number as u32);
    let Some(written) = bytes.get(fields_end..fields_end + HEADER_CHECKSUM_BYTES) else {
        return Parsed::Incomplete;
    };
    if written != &header_checksum.to_le_bytes()[..HEADER_CHECKSUM_BYTES] {
        return Parsed::Damaged("has a header that does not match its checksum");
    }
    if number > 0 && length as usize > MAX_PAYLOAD {
        return Parsed::Damaged("is longer than any block may be");
    }
    let checksum_start = fields_end + HEADER_CHECKSUM_BYTES;
    let start = checksum_start + PAYLOAD_CHECKSUM_BYTES;
    let end = start + length as usize;
    let Some(payload) = bytes.get(start..end) else { return Parsed::Incomplete };
    if bytes[checksum_start..start] != xxh32(payload, header_checksum).to_le_bytes() {
        return Parsed::Damaged("does not match its checksum");
    }
    Parsed::Block(Block { tag, steps, payload }, end)
}

/// Parses a block whatever its checksums. Returns it with its total length; one that is cut short
/// ends there.
pub(super) fn parse_unchecked(bytes: &[u8]) -> Option<(Block<'_>, usize)> {
    let Fields::Complete(fields_end, [length, tag, steps]) = parse_fields(bytes) else {
        return None;
    };
    let start = fields_end + HEADER_CHECKSUM_BYTES + PAYLOAD_CHECKSUM_BYTES;
    let payload = bytes.get(start..)?;
    let payload = &payload[..payload.len().min(length as usize)];
    Some((Block { tag, steps, payload }, start + payload.len()))
}

/// The numbers that a block begins with: length of its payload, tag, steps.
enum Fields {
    /// All of them, and their length in bytes.
    Complete(usize, [u32; 3]),
    Incomplete,
    Invalid,
}

fn parse_fields(bytes: &[u8]) -> Fields {
    let mut unread = bytes;
    let mut fields = [0u32; 3];
    for field in &mut fields {
        // A number that is cut short is no error: the rest is still to come.
        let is_complete = unread.iter().take(5).any(|byte| byte & 0x80 == 0);
        if !is_complete && unread.len() < 5 {
            return Fields::Incomplete;
        }
        match take_leb128(&mut unread, u64::from(u32::MAX)) {
            Some(number) => *field = number as u32,
            None => return Fields::Invalid,
        }
    }
    Fields::Complete(bytes.len() - unread.len(), fields)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_read_whole_or_not_at_all_and_no_bit_of_it_can_flip() {
        let block = Block { tag: 300, steps: 7, payload: b"any bytes at all" };
        let mut bytes = Vec::new();
        put(&mut bytes, 5, block);
        assert_eq!(parse(&bytes, 5), Parsed::Block(block, bytes.len()));
        for n in 0..bytes.len() {
            assert_eq!(parse(&bytes[..n], 5), Parsed::Incomplete, "{n} bytes");
        }
        assert!(matches!(parse(&bytes, 6), Parsed::Damaged(_)), "another number");
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            // Long enough for any length that a flip could make of it.
            damaged.resize(bytes.len() + (1 << 16), 0);
            assert!(matches!(parse(&damaged, 5), Parsed::Damaged(_)), "bit {bit}");
        }
    }
}
