//! The attribute codec: blocks of vertices, each byte of the element a plane of its own, groups of
//! 16 deltas with 0 to 8 bits each. Bitstream versions 0 and 1 are decoded, 0 is encoded.

// All of these are set by the specification of the extension.

/// Deltas of a group, which all have the same number of bits.
const GROUP_DELTAS: usize = 16;
/// Largest number of bytes in a block.
const BLOCK_BYTES: usize = 8192;
/// Largest number of vertices in a block.
const BLOCK_VERTICES: usize = 256;

/// Least bytes of the stream's tail by version.
const MIN_TAIL_BYTES: [usize; 2] = [32, 24];

/// Bits per delta by the two bits of a group's header: version 0, then the two tables of version 1.
const BITS: [[u8; 4]; 3] = [[0, 2, 4, 8], [0, 1, 2, 4], [1, 2, 4, 8]];

/// Vertices of a block.
fn block(stride: usize) -> usize {
    (BLOCK_BYTES / stride / GROUP_DELTAS * GROUP_DELTAS).min(BLOCK_VERTICES)
}

/// The small number that marks a delta with more bits, whose byte follows after its group.
fn sentinel(bits: u8) -> u8 {
    (1 << bits) - 1
}

/// Decodes `count` elements of `stride` bytes, a multiple of 4 up to 256.
pub(super) fn decode(count: usize, stride: usize, bytes: &[u8]) -> Result<Vec<u8>, &'static str> {
    let version = match bytes.first() {
        Some(0xa0) => 0,
        Some(0xa1) => 1,
        Some(_) => return Err("not an attribute stream of version 0 or 1"),
        None => return Err("no bytes"),
    };
    // The tail, at the very end, holds the element before the first one and, since version 1, a
    // mode per 4 bytes.
    let tail = stride + if version == 1 { stride / 4 } else { 0 };
    let padded_tail = tail.max(MIN_TAIL_BYTES[version]);
    let data_end = bytes.len().checked_sub(padded_tail).filter(|&end| end >= 1);
    let mut data = Reader { bytes: &bytes[1..data_end.ok_or("too short")?] };
    let start = bytes.len() - tail;
    let mut last: Vec<u8> = bytes[start..start + stride].to_vec();
    let channels: Vec<u8> =
        if version == 1 { bytes[start + stride..].to_vec() } else { vec![0; stride / 4] };

    let block = block(stride);
    // Before allocating: even a block of nothing but zeros takes this many bytes.
    let min_block_bytes = if version == 1 { stride / 4 } else { stride };
    if count.div_ceil(block).checked_mul(min_block_bytes).is_none_or(|n| n > data.bytes.len()) {
        return Err("too short for its count");
    }
    let mut out = vec![0; count.checked_mul(stride).ok_or("too large")?];
    let mut planes = vec![0; 4 * BLOCK_VERTICES];
    for chunk in out.chunks_mut(block * stride) {
        let vertices = chunk.len() / stride;
        let padded = vertices.div_ceil(GROUP_DELTAS) * GROUP_DELTAS;
        let control = if version == 1 { data.take(stride / 4)? } else { &[] };
        for (channel, &mode) in channels.iter().enumerate() {
            for (byte, plane) in planes.chunks_mut(BLOCK_VERTICES).enumerate() {
                let plane = &mut plane[..padded];
                match control.get(channel).map(|c| c >> (2 * byte) & 3) {
                    None => data.plane(plane, BITS[0])?,
                    Some(0) => data.plane(plane, BITS[1])?,
                    Some(1) => data.plane(plane, BITS[2])?,
                    Some(2) => plane.fill(0),
                    Some(_) => plane[..vertices].copy_from_slice(data.take(vertices)?),
                }
            }
            let first = channel * 4;
            let elements = chunk[first..].chunks_mut(stride);
            integrate(mode, &planes, &mut last[first..first + 4], elements)?;
        }
    }
    if !data.bytes.is_empty() {
        return Err("bytes left over");
    }
    Ok(out)
}

/// Turns deltas into values: 4 bytes of every element. `mode` is the channel's: whether deltas are
/// of bytes, of 16-bit numbers, or bits that differ.
fn integrate<'a>(
    mode: u8,
    planes: &[u8],
    last: &mut [u8],
    elements: impl Iterator<Item = &'a mut [u8]>,
) -> Result<(), &'static str> {
    let mut p = [last[0], last[1], last[2], last[3]];
    for (i, element) in elements.enumerate() {
        let d: [u8; 4] = std::array::from_fn(|k| planes[k * BLOCK_VERTICES + i]);
        p = match mode & 3 {
            0 => std::array::from_fn(|k| p[k].wrapping_add(d[k] >> 1 ^ (d[k] & 1).wrapping_neg())),
            1 => {
                let half = |k: usize| {
                    let d = u16::from_le_bytes([d[k], d[k + 1]]);
                    u16::from_le_bytes([p[k], p[k + 1]])
                        .wrapping_add(d >> 1 ^ (d & 1).wrapping_neg())
                        .to_le_bytes()
                };
                let (low, high) = (half(0), half(2));
                [low[0], low[1], high[0], high[1]]
            }
            2 => {
                let turned = u32::from_le_bytes(d).rotate_right(u32::from(mode >> 4));
                (u32::from_le_bytes(p) ^ turned).to_le_bytes()
            }
            _ => return Err("an unknown kind of channel"),
        };
        element[..4].copy_from_slice(&p);
    }
    last.copy_from_slice(&p);
    Ok(())
}

struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], &'static str> {
        let (taken, unread) = self.bytes.split_at_checked(n).ok_or("the stream is truncated")?;
        self.bytes = unread;
        Ok(taken)
    }

    /// One byte of every element of a block; `plane` is a whole number of groups.
    fn plane(&mut self, plane: &mut [u8], bits: [u8; 4]) -> Result<(), &'static str> {
        let header = self.take((plane.len() / GROUP_DELTAS).div_ceil(4))?;
        for (g, group) in plane.chunks_exact_mut(GROUP_DELTAS).enumerate() {
            match bits[usize::from(header[g / 4] >> (g % 4 * 2) & 3)] {
                0 => group.fill(0),
                8 => group.copy_from_slice(self.take(GROUP_DELTAS)?),
                bits => self.group(group, bits)?,
            }
        }
        Ok(())
    }

    /// 16 small numbers.
    fn group(&mut self, group: &mut [u8], bits: u8) -> Result<(), &'static str> {
        let packed = self.take(GROUP_DELTAS * usize::from(bits) / 8)?;
        let per_byte = usize::from(8 / bits);
        for (i, value) in group.iter_mut().enumerate() {
            // Single bits are packed from the lowest up, the others from the highest down.
            let shift =
                if bits == 1 { i % 8 } else { (per_byte - 1 - i % per_byte) * usize::from(bits) };
            let small = packed[i / per_byte] >> shift & sentinel(bits);
            *value = if small == sentinel(bits) { self.take(1)?[0] } else { small };
        }
        Ok(())
    }
}

/// Encodes elements of `stride` bytes, a multiple of 4 up to 256.
pub(super) fn encode(stride: usize, bytes: &[u8]) -> Vec<u8> {
    let mut out = vec![0xa0];
    let first = bytes.get(..stride).unwrap_or(&[]);
    let mut last = first.to_vec();
    for chunk in bytes.chunks(block(stride) * stride) {
        let elements = chunk.len() / stride;
        let mut plane = vec![0; elements.next_multiple_of(GROUP_DELTAS)];
        for (byte, last) in last.iter_mut().enumerate() {
            for (delta, &value) in plane.iter_mut().zip(chunk[byte..].iter().step_by(stride)) {
                *delta = zigzag(value.wrapping_sub(*last));
                *last = value;
            }
            put_plane(&mut out, &plane);
        }
    }
    // The decoder reads the element before the first one from the very end.
    out.resize(out.len() + MIN_TAIL_BYTES[0].saturating_sub(first.len()), 0);
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
    out.resize(header + (plane.len() / GROUP_DELTAS).div_ceil(4), 0);
    for (g, group) in plane.chunks_exact(GROUP_DELTAS).enumerate() {
        let code = packing(group);
        out[header + g / 4] |= (code as u8) << (g % 4 * 2);
        match BITS[0][code] {
            0 => {}
            8 => out.extend_from_slice(group),
            bits => put_group(out, group, bits),
        }
    }
}

/// The code of the bits per delta that take the fewest bytes.
fn packing(group: &[u8]) -> usize {
    if group.iter().all(|&d| d == 0) {
        return 0;
    }
    let size = |&code: &usize| match BITS[0][code] {
        8 => GROUP_DELTAS,
        bits => {
            let full_bytes = group.iter().filter(|&&d| d >= sentinel(bits));
            GROUP_DELTAS * usize::from(bits) / 8 + full_bytes.count()
        }
    };
    (1..4).min_by_key(size).expect("three codes")
}

/// 16 small numbers, the first in the highest bits, then those that are too large as bytes.
fn put_group(out: &mut Vec<u8>, group: &[u8], bits: u8) {
    let pack = |packed: u8, &d: &u8| packed << bits | d.min(sentinel(bits));
    out.extend(group.chunks_exact(usize::from(8 / bits)).map(|part| part.iter().fold(0, pack)));
    out.extend(group.iter().filter(|&&d| d >= sentinel(bits)));
}
