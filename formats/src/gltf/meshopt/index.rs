//! The two index codecs: triangles through a cache of recent edges and vertices, and plain
//! sequences of deltas.

use super::recent::Recent;

/// Decodes a triangle list of `count` indices, a multiple of 3. Bitstream versions 0 and 1.
pub(super) fn triangles(count: usize, bytes: &[u8]) -> Result<Vec<u32>, &'static str> {
    let version = match bytes.first() {
        Some(0xe0) => 0,
        Some(0xe1) => 1,
        _ => return Err("not a triangle stream of version 0 or 1"),
    };
    // One code per triangle, then what the codes need, then a table of 16 frequent codes.
    let body = bytes.get(1..bytes.len().saturating_sub(16)).ok_or("too short")?;
    let table = &bytes[bytes.len() - 16..];
    let (codes, rest) = body.split_at_checked(count / 3).ok_or("too short for its count")?;
    let mut s = Decoder { rest, recent: Recent::default(), next: 0, last: 0 };
    let cached_limit = if version == 1 { 13 } else { 15 };
    let mut out = Vec::with_capacity(count);
    for &code in codes {
        let (high, low) = (usize::from(code >> 4), usize::from(code & 15));
        let [a, b, c] = if high < 15 {
            let [a, b] = s.recent.edge(high);
            let c = if low == 0 {
                let c = s.fresh();
                s.recent.push_vertex(c);
                c
            } else if low < cached_limit {
                s.recent.vertex(low)
            } else {
                let c = match low {
                    13 => s.last.wrapping_sub(1),
                    14 => s.last.wrapping_add(1),
                    _ => s.free()?,
                };
                s.last = c;
                s.recent.push_vertex(c);
                c
            };
            s.recent.push_edge([c, b]);
            s.recent.push_edge([a, c]);
            [a, b, c]
        } else {
            let (first, pair) = match low {
                14 => (0, s.byte()?),
                15 => (15, s.byte()?),
                _ => (0, table[low]),
            };
            if low >= 14 && pair == 0 {
                s.next = 0;
            }
            let triangle = s.corners([first, usize::from(pair >> 4), usize::from(pair & 15)])?;
            let [a, b, c] = triangle;
            s.recent.push_edge([b, a]);
            s.recent.push_edge([c, b]);
            s.recent.push_edge([a, c]);
            triangle
        };
        out.extend([a, b, c]);
    }
    if s.rest.is_empty() { Ok(out) } else { Err("bytes left over") }
}

/// Decodes a sequence of `count` indices. Bitstream versions 0 and 1.
pub(super) fn sequence(count: usize, bytes: &[u8]) -> Result<Vec<u32>, &'static str> {
    if !matches!(bytes.first(), Some(0xd0 | 0xd1)) {
        return Err("not an index stream of version 0 or 1");
    }
    // Four bytes of padding end the stream; every index takes at least one byte.
    let mut rest = bytes.get(1..bytes.len().saturating_sub(4)).ok_or("too short")?;
    if count > rest.len() {
        return Err("too short for its count");
    }
    let mut last = [0u32; 2];
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        let v = varint(&mut rest)?;
        let baseline = &mut last[(v & 1) as usize];
        *baseline = baseline.wrapping_add(unzigzag(v >> 1));
        out.push(*baseline);
    }
    if rest.is_empty() { Ok(out) } else { Err("bytes left over") }
}

struct Decoder<'a> {
    rest: &'a [u8],
    recent: Recent,
    /// The smallest index that has not been seen.
    next: u32,
    /// Reference that free indices are deltas of.
    last: u32,
}

impl Decoder<'_> {
    fn byte(&mut self) -> Result<u8, &'static str> {
        let (&byte, rest) = self.rest.split_first().ok_or("the stream ends too early")?;
        self.rest = rest;
        Ok(byte)
    }

    fn fresh(&mut self) -> u32 {
        let index = self.next;
        self.next = index.wrapping_add(1);
        index
    }

    fn free(&mut self) -> Result<u32, &'static str> {
        self.last = self.last.wrapping_add(unzigzag(varint(&mut self.rest)?));
        Ok(self.last)
    }

    /// A triangle that shares no recent edge. Per corner: 0 a fresh index, 15 a free one, else a
    /// recent one.
    fn corners(&mut self, codes: [usize; 3]) -> Result<[u32; 3], &'static str> {
        // All corners are looked up before any is remembered, and free ones stand after the codes
        // in the data.
        let mut corners = codes.map(|code| match code {
            0 => self.fresh(),
            15 => 0,
            _ => self.recent.vertex(code - 1),
        });
        for (corner, _) in corners.iter_mut().zip(codes).filter(|(_, code)| *code == 15) {
            *corner = self.free()?;
        }
        for (&corner, _) in corners.iter().zip(codes).filter(|(_, code)| *code == 0 || *code == 15)
        {
            self.recent.push_vertex(corner);
        }
        Ok(corners)
    }
}

fn varint(bytes: &mut &[u8]) -> Result<u32, &'static str> {
    let mut value = 0;
    for i in 0..5 {
        let (&byte, rest) = bytes.split_first().ok_or("the stream ends too early")?;
        *bytes = rest;
        value |= u32::from(byte & 127) << (7 * i);
        if byte < 128 {
            return Ok(value);
        }
    }
    Err("a number of more than 32 bits")
}

fn unzigzag(v: u32) -> u32 {
    v >> 1 ^ (v & 1).wrapping_neg()
}
