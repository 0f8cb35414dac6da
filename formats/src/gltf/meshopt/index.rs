//! The two index codecs: triangles through a cache of recent edges and vertices, both ways, and
//! plain sequences of deltas, decoded.

/// Frequent pairs of codes for the second and third corner of a triangle without a recent edge.
const FREQUENT: [u8; 16] = [
    0x00, 0x76, 0x87, 0x56, 0x67, 0x78, 0xa9, 0x86, 0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0x00, 0x00,
];
/// Codes below this name a recent vertex as the third corner of a triangle at a recent edge, in
/// version 1.
const MAX_CACHED: usize = 13;

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
    let (codes, unread) = body.split_at_checked(count / 3).ok_or("too short for its count")?;
    let mut s = Decoder { unread, recent: Recent::default(), next: 0, last: 0 };
    let cached_limit = if version == 1 { MAX_CACHED } else { 15 };
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
            s.recent.push_edges([[c, b], [a, c]]);
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
            s.recent.push_edges([[b, a], [c, b], [a, c]]);
            triangle
        };
        out.extend([a, b, c]);
    }
    if s.unread.is_empty() { Ok(out) } else { Err("bytes left over") }
}

/// Decodes a sequence of `count` indices. Bitstream versions 0 and 1.
pub(super) fn sequence(count: usize, bytes: &[u8]) -> Result<Vec<u32>, &'static str> {
    if !matches!(bytes.first(), Some(0xd0 | 0xd1)) {
        return Err("not an index stream of version 0 or 1");
    }
    // Four bytes of padding end the stream; every index takes at least one byte.
    let mut unread = bytes.get(1..bytes.len().saturating_sub(4)).ok_or("too short")?;
    if count > unread.len() {
        return Err("too short for its count");
    }
    let mut last = [0u32; 2];
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        let v = varint(&mut unread)?;
        let baseline = &mut last[(v & 1) as usize];
        *baseline = baseline.wrapping_add(unzigzag(v >> 1));
        out.push(*baseline);
    }
    if unread.is_empty() { Ok(out) } else { Err("bytes left over") }
}

struct Decoder<'a> {
    unread: &'a [u8],
    recent: Recent,
    /// The smallest index that has not been seen.
    next: u32,
    /// Reference that free indices are deltas of.
    last: u32,
}

impl Decoder<'_> {
    fn byte(&mut self) -> Result<u8, &'static str> {
        let (&byte, unread) = self.unread.split_first().ok_or("the stream is truncated")?;
        self.unread = unread;
        Ok(byte)
    }

    fn fresh(&mut self) -> u32 {
        let index = self.next;
        self.next = index.wrapping_add(1);
        index
    }

    fn free(&mut self) -> Result<u32, &'static str> {
        self.last = self.last.wrapping_add(unzigzag(varint(&mut self.unread)?));
        Ok(self.last)
    }

    /// A triangle that shares no recent edge. Codes of corners: 0 is the smallest index that has
    /// not been seen (fresh), 15 an index as a delta in the data (free), others are recent ones.
    fn corners(&mut self, codes: [usize; 3]) -> Result<[u32; 3], &'static str> {
        // All corners are looked up before any is remembered, and free ones come after the codes
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
        let (&byte, unread) = bytes.split_first().ok_or("the stream is truncated")?;
        *bytes = unread;
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

/// Encodes triangles. Decoding may turn their corners round, never over.
pub(super) fn encode(triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut s = Encoder::default();
    let mut codes = vec![0xe1];
    for &triangle in triangles {
        codes.push(match edge_of(&s.recent, triangle) {
            Some((age, turned)) => s.at_edge(age, turned),
            None => s.without_edge(triangle),
        });
    }
    codes.append(&mut s.data);
    codes.extend(FREQUENT);
    codes
}

#[derive(Default)]
struct Encoder {
    /// The bytes that follow the codes.
    data: Vec<u8>,
    recent: Recent,
    /// The smallest index that has not been seen.
    next: u32,
    /// Reference that free indices are deltas of.
    last: u32,
}

impl Encoder {
    /// The code of a triangle whose first two corners are a recent edge.
    fn at_edge(&mut self, age: usize, [a, b, c]: [u32; 3]) -> u8 {
        let code = match age_of(&self.recent, c) {
            Some(vertex) if (1..MAX_CACHED).contains(&vertex) => vertex,
            _ if c == self.next => {
                self.next += 1;
                self.recent.push_vertex(c);
                0
            }
            _ => {
                let code = match c {
                    _ if c.wrapping_add(1) == self.last => 13,
                    _ if c == self.last.wrapping_add(1) => 14,
                    _ => 15,
                };
                if code == 15 {
                    self.put_free(c);
                }
                self.last = c;
                self.recent.push_vertex(c);
                code
            }
        };
        self.recent.push_edges([[c, b], [a, c]]);
        (age << 4 | code) as u8
    }

    /// The code of a triangle that shares no recent edge.
    fn without_edge(&mut self, [a, b, c]: [u32; 3]) -> u8 {
        let triangle = match self.next {
            next if b == next => [b, c, a],
            next if c == next => [c, a, b],
            _ => [a, b, c],
        };
        let [a, b, c] = triangle;
        // A new primitive, whose indices begin again at 0.
        let reset = triangle == [0, 1, 2] && self.next > 0;
        if reset {
            self.next = 0;
            self.recent.forget_vertices();
        }
        let first = if a == self.next { self.fresh() } else { 15 };
        let (second, third) = (self.corner(b), self.corner(c));
        let pair = (second << 4 | third) as u8;
        let frequent = FREQUENT[..14].iter().position(|&f| f == pair);
        let code = match frequent {
            Some(index) if first == 0 && !reset => index,
            _ => {
                self.data.push(pair);
                14 | first
            }
        };
        for (corner, code) in [(a, first), (b, second), (c, third)] {
            if code == 15 {
                self.put_free(corner);
                self.last = corner;
            }
        }
        for (corner, code) in [(a, first), (b, second), (c, third)] {
            if code == 0 || code == 15 {
                self.recent.push_vertex(corner);
            }
        }
        self.recent.push_edges([[b, a], [c, b], [a, c]]);
        (15 << 4 | code) as u8
    }

    /// The code of a corner: 0 a fresh index, 15 a free one, else a recent one.
    fn corner(&mut self, v: u32) -> usize {
        match age_of(&self.recent, v) {
            Some(age) if age < 14 => age + 1,
            _ if v == self.next => self.fresh(),
            _ => 15,
        }
    }

    fn fresh(&mut self) -> usize {
        self.next += 1;
        0
    }

    /// An index as a delta, seven bits a byte.
    fn put_free(&mut self, index: u32) {
        let delta = index.wrapping_sub(self.last);
        let mut value = delta << 1 ^ (delta >> 31).wrapping_neg();
        while value > 127 {
            self.data.push((value & 127) as u8 | 128);
            value >>= 7;
        }
        self.data.push(value as u8);
    }
}

/// Returns the age of an edge of the triangle (0: just used, at most 14), and the triangle turned
/// so that the edge comes first.
fn edge_of(recent: &Recent, [a, b, c]: [u32; 3]) -> Option<(usize, [u32; 3])> {
    (0..15).find_map(|age| {
        let edge = recent.edge(age);
        let mut turned = [[a, b, c], [b, c, a], [c, a, b]].into_iter();
        turned.find(|t| [t[0], t[1]] == edge).map(|t| (age, t))
    })
}

/// Returns the age of a vertex (0: just seen).
fn age_of(recent: &Recent, v: u32) -> Option<usize> {
    (0..16).find(|&age| recent.vertex(age) == v)
}

/// What both sides of the codec of triangle lists remember: the 16 latest edges and vertices.
struct Recent {
    edges: [[u32; 2]; 16],
    vertices: [u32; 16],
    /// Where the next edge is put.
    edge_slot: usize,
    /// Where the next vertex is put.
    vertex_slot: usize,
}

impl Default for Recent {
    fn default() -> Self {
        Self { edges: [[u32::MAX; 2]; 16], vertices: [u32::MAX; 16], edge_slot: 0, vertex_slot: 0 }
    }
}

impl Recent {
    /// Returns an edge by its age: 0 is the latest.
    fn edge(&self, age: usize) -> [u32; 2] {
        self.edges[(self.edge_slot + 31 - age) & 15]
    }
    /// Returns a vertex by its age: 0 is the latest.
    fn vertex(&self, age: usize) -> u32 {
        self.vertices[(self.vertex_slot + 31 - age) & 15]
    }
    fn push_edges<const N: usize>(&mut self, edges: [[u32; 2]; N]) {
        for edge in edges {
            self.edges[self.edge_slot & 15] = edge;
            self.edge_slot = (self.edge_slot + 1) & 15;
        }
    }
    fn push_vertex(&mut self, vertex: u32) {
        self.vertices[self.vertex_slot & 15] = vertex;
        self.vertex_slot = (self.vertex_slot + 1) & 15;
    }
    fn forget_vertices(&mut self) {
        self.vertices = [u32::MAX; 16];
    }
}
