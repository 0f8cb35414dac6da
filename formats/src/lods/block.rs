//! Blocks: what a stream is cut into, each with checksums of its own.

use lodc_mesh::put_leb128;
use xxhash_rust::xxh3::xxh3_64_with_seed;

/// First bytes of a stream. Not text, not valid UTF-8, and damaged by a transfer that changes line
/// ends.
pub(super) const MAGIC: [u8; 8] = *b"\x89LODS\r\n\x1a";
/// Bytes before the first block: [`MAGIC`] and the version.
pub(super) const PREAMBLE: usize = 12;
/// The most bytes of a block that holds steps; the first block may have more.
pub(super) const LARGEST: usize = 16 << 20;
const HEAD_CHECK: usize = 2;
const BODY_CHECK: usize = 4;

/// A block whose checksums are right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Block<'a> {
    /// 0: the head or the end of the stream; else one more than the number of an object.
    pub(super) subject: u32,
    /// How many steps it has.
    pub(super) steps: u32,
    pub(super) payload: &'a [u8],
}

/// What stands at a place of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parsed<'a> {
    /// A block, and its bytes in all.
    Block(Block<'a>, usize),
    /// The beginning of one.
    Part,
    /// None.
    Damaged(&'static str),
}

/// Appends a block. `number` counts the blocks of a stream.
pub(super) fn put(out: &mut Vec<u8>, number: u64, block: Block<'_>) {
    let start = out.len();
    for n in [block.payload.len() as u32, block.subject, block.steps] {
        put_leb128(out, n.into());
    }
    let check = xxh3_64_with_seed(&out[start..], number);
    out.extend_from_slice(&check.to_le_bytes()[..HEAD_CHECK]);
    let body = xxh3_64_with_seed(block.payload, check);
    out.extend_from_slice(&body.to_le_bytes()[..BODY_CHECK]);
    out.extend_from_slice(block.payload);
}

/// Looks at what stands at the beginning of `bytes`, which should be block `number`.
pub(super) fn parse(bytes: &[u8], number: u64) -> Parsed<'_> {
    let (at, [length, subject, steps]) = match fields(bytes) {
        Fields::Read(at, fields) => (at, fields),
        Fields::Part => return Parsed::Part,
        Fields::Wrong => {
            return Parsed::Damaged("has a number that is not written as it should be");
        }
    };
    let check = xxh3_64_with_seed(&bytes[..at], number);
    let Some(written) = bytes.get(at..at + HEAD_CHECK) else { return Parsed::Part };
    if written != &check.to_le_bytes()[..HEAD_CHECK] {
        return Parsed::Damaged("has a header that does not match its checksum");
    }
    if number > 0 && length as usize > LARGEST {
        return Parsed::Damaged("is longer than any block may be");
    }
    let check_at = at + HEAD_CHECK;
    let start = check_at + BODY_CHECK;
    let Some(payload) = bytes.get(start..start + length as usize) else { return Parsed::Part };
    if bytes[check_at..start] != xxh3_64_with_seed(payload, check).to_le_bytes()[..BODY_CHECK] {
        return Parsed::Damaged("does not match its checksum");
    }
    Parsed::Block(Block { subject, steps, payload }, start + length as usize)
}

/// A block whatever its checksums, and its bytes in all; one that is cut short ends where it is
/// cut.
pub(super) fn believed(bytes: &[u8]) -> Option<(Block<'_>, usize)> {
    let Fields::Read(at, [length, subject, steps]) = fields(bytes) else { return None };
    let start = at + HEAD_CHECK + BODY_CHECK;
    let payload = bytes.get(start..)?;
    let payload = &payload[..payload.len().min(length as usize)];
    Some((Block { subject, steps, payload }, start + payload.len()))
}

/// The numbers that a block begins with: bytes of its payload, subject, steps.
enum Fields {
    Read(usize, [u32; 3]),
    Part,
    Wrong,
}

fn fields(bytes: &[u8]) -> Fields {
    let mut at = 0;
    let mut fields = [0u32; 3];
    for field in &mut fields {
        match varint(&bytes[at..]) {
            Some(Ok((value, length))) => (*field, at) = (value, at + length),
            Some(Err(())) => return Fields::Wrong,
            None => return Fields::Part,
        }
    }
    Fields::Read(at, fields)
}

/// A number as `put_varint` writes it, and its bytes; none if it is cut short, an error if nobody
/// would write it so.
pub(super) fn varint(bytes: &[u8]) -> Option<Result<(u32, usize), ()>> {
    let mut value = 0;
    for (i, &byte) in bytes.iter().enumerate() {
        // More than 32 bits, or a number that could be shorter.
        if i == 4 && byte > 15 || i > 0 && byte == 0 {
            return Some(Err(()));
        }
        value |= u32::from(byte & 0x7f) << (7 * i);
        if byte < 0x80 {
            return Some(Ok((value, i + 1)));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_read_whole_or_not_at_all_and_no_bit_of_it_can_flip() {
        let block = Block { subject: 300, steps: 7, payload: b"any bytes at all" };
        let mut bytes = Vec::new();
        put(&mut bytes, 5, block);
        assert_eq!(parse(&bytes, 5), Parsed::Block(block, bytes.len()));
        for n in 0..bytes.len() {
            assert_eq!(parse(&bytes[..n], 5), Parsed::Part, "{n} bytes");
        }
        assert!(matches!(parse(&bytes, 6), Parsed::Damaged(_)), "another place in the stream");
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            // Long enough for any length that a flip could make of it.
            damaged.resize(bytes.len() + (1 << 16), 0);
            assert!(matches!(parse(&damaged, 5), Parsed::Damaged(_)), "bit {bit}");
        }
    }
}
