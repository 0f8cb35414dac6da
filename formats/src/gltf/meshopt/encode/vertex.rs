//! The attribute codec, bitstream version 0: blocks of vertices, each byte of the element a plane
//! of its own, deltas in groups of 16 with 0, 2, 4 or 8 bits each.

const GROUP: usize = 16;
const BLOCK_BYTES: usize = 8192;
const BLOCK_VERTICES: usize = 256;
/// Bytes of the stream's tail, at least.
const TAIL: usize = 32;

/// Encodes elements of `stride` bytes, a multiple of 4 up to 256.
pub(super) fn encode(stride: usize, bytes: &[u8]) -> Vec<u8> {
    let mut out = vec![0xa0];
    let first = bytes.get(..stride).unwrap_or(&[]);
    let mut last = first.to_vec();
    let block = (BLOCK_BYTES / stride / GROUP * GROUP).min(BLOCK_VERTICES);
    for chunk in bytes.chunks(block * stride) {
        let elements = chunk.len() / stride;
        let mut plane = vec![0; elements.next_multiple_of(GROUP)];
        for (byte, last) in last.iter_mut().enumerate() {
            for (delta, &value) in plane.iter_mut().zip(chunk[byte..].iter().step_by(stride)) {
                *delta = zigzag(value.wrapping_sub(*last));
                *last = value;
            }
            put_plane(&mut out, &plane);
        }
    }
    // The decoder reads the element before the first one from the very end.
    out.resize(out.len() + TAIL.saturating_sub(first.len()), 0);
    out.extend_from_slice(first);
    out
}

fn zigzag(delta: u8) -> u8 {
    delta << 1 ^ (delta >> 7).wrapping_neg()
}

/// One byte of every element of a block: two bits per group that say how it is packed, then the
/// groups.
fn put_plane(out: &mut Vec<u8>, plane: &[u8]) {
    let header = out.len();
    out.resize(header + (plane.len() / GROUP).div_ceil(4), 0);
    for (g, group) in plane.chunks_exact(GROUP).enumerate() {
        let (code, bits) = packing(group);
        out[header + g / 4] |= code << (g % 4 * 2);
        match bits {
            0 => {}
            8 => out.extend_from_slice(group),
            bits => put_group(out, group, bits),
        }
    }
}

/// The code and the bits per delta that take the fewest bytes.
fn packing(group: &[u8]) -> (u8, u32) {
    if group.iter().all(|&d| d == 0) {
        return (0, 0);
    }
    let size = |bits: u32| {
        let sentinel = (1u8 << bits) - 1;
        GROUP * bits as usize / 8 + group.iter().filter(|&&d| d >= sentinel).count()
    };
    let (two, four) = (size(2), size(4));
    match two.min(four).min(GROUP) {
        best if best == two => (1, 2),
        best if best == four => (2, 4),
        _ => (3, 8),
    }
}

/// 16 small numbers, the first in the highest bits; the largest one means that a whole byte
/// follows after all of them.
fn put_group(out: &mut Vec<u8>, group: &[u8], bits: u32) {
    let sentinel = (1u8 << bits) - 1;
    let pack = |packed: u8, &d: &u8| packed << bits | d.min(sentinel);
    out.extend(group.chunks_exact(8 / bits as usize).map(|part| part.iter().fold(0, pack)));
    out.extend(group.iter().filter(|&&d| d >= sentinel));
}
