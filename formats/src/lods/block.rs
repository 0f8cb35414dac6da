//! Blocks of a `.lods` stream: kind, length, payload, and checksums of both, so that a reader can
//! use each block as soon as it has arrived.

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
/// The most bytes of a payload of steps; that of the first block may be longer.
pub(super) const MAX_PAYLOAD: usize = 16 << 20;
const HEADER_CHECK: usize = 2;
const PAYLOAD_CHECK: usize = 4;

/// A block whose checksums are right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Block<'a> {
    /// 0: the head or the end of the stream; else one more than the number of an object.
    pub(super) tag: u32,
    /// Number of steps.
    pub(super) steps: u32,
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
    let check = xxh32(&out[start..], number as u32);
    out.extend_from_slice(&check.to_le_bytes()[..HEADER_CHECK]);
    out.extend_from_slice(&xxh32(block.payload, check).to_le_bytes());
    out.extend_from_slice(block.payload);
}

/// Parses block `number` from the beginning of `bytes`.
pub(super) fn parse(bytes: &[u8], number: u64) -> Parsed<'_> {
    let (at, [length, tag, steps]) = match parse_fields(bytes) {
        Fields::Complete(at, fields) => (at, fields),
        Fields::Incomplete => return Parsed::Incomplete,
        Fields::Invalid => {
            return Parsed::Damaged("has a number that is not written as it should be");
        }
    };
    let check = xxh32(&bytes[..at], number as u32);
    let Some(written) = bytes.get(at..at + HEADER_CHECK) else { return Parsed::Incomplete };
    if written != &check.to_le_bytes()[..HEADER_CHECK] {
        return Parsed::Damaged("has a header that does not match its checksum");
    }
    if number > 0 && length as usize > MAX_PAYLOAD {
        return Parsed::Damaged("is longer than any block may be");
    }
    let check_at = at + HEADER_CHECK;
    let start = check_at + PAYLOAD_CHECK;
    let end = start + length as usize;
    let Some(payload) = bytes.get(start..end) else { return Parsed::Incomplete };
    if bytes[check_at..start] != xxh32(payload, check).to_le_bytes() {
        return Parsed::Damaged("does not match its checksum");
    }
    Parsed::Block(Block { tag, steps, payload }, end)
}

/// Parses a block whatever its checksums. Returns it with its total length; one that is cut short
/// ends there.
pub(super) fn parse_unchecked(bytes: &[u8]) -> Option<(Block<'_>, usize)> {
    let Fields::Complete(at, [length, tag, steps]) = parse_fields(bytes) else { return None };
    let start = at + HEADER_CHECK + PAYLOAD_CHECK;
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
    let mut rest = bytes;
    let mut fields = [0u32; 3];
    for field in &mut fields {
        // A number that is cut short is no error: the rest is still to come.
        let ends = rest.iter().take(5).any(|byte| byte & 0x80 == 0);
        if !ends && rest.len() < 5 {
            return Fields::Incomplete;
        }
        match take_leb128(&mut rest, u64::from(u32::MAX)) {
            Some(number) => *field = number as u32,
            None => return Fields::Invalid,
        }
    }
    Fields::Complete(bytes.len() - rest.len(), fields)
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
