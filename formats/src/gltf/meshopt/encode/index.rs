//! The codec of triangle lists, bitstream version 1: through a cache of recent edges and vertices.

use crate::import::gltf::meshopt::recent::Recent;

/// Frequent pairs of codes for the second and third corner of a triangle without a recent edge.
const FREQUENT: [u8; 16] = [
    0x00, 0x76, 0x87, 0x56, 0x67, 0x78, 0xa9, 0x86, 0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0x00, 0x00,
];
/// Recent vertices that the third corner of a triangle at a recent edge may be.
const CACHED: usize = 13;

/// Encodes triangles. Decoding may turn their corners round, never over.
pub(super) fn encode(triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut s = Encoder::default();
    let mut codes = vec![0xe1];
    for &triangle in triangles {
        codes.push(match edge_of(&s.recent, triangle) {
            Some((back, turned)) => s.at_edge(back, turned),
            None => s.apart(triangle),
        });
    }
    codes.append(&mut s.data);
    codes.extend(FREQUENT);
    codes
}

#[derive(Default)]
struct Encoder {
    /// Bytes that codes need besides.
    data: Vec<u8>,
    recent: Recent,
    /// The smallest index that has not been seen.
    next: u32,
    /// Reference that free indices are deltas of.
    last: u32,
}

impl Encoder {
    /// A triangle whose first two corners are a recent edge.
    fn at_edge(&mut self, back: usize, [a, b, c]: [u32; 3]) -> u8 {
        let code = match age_of(&self.recent, c) {
            Some(vertex) if (1..CACHED).contains(&vertex) => vertex,
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
        self.recent.push_edge([c, b]);
        self.recent.push_edge([a, c]);
        (back << 4 | code) as u8
    }

    /// A triangle that shares no recent edge.
    fn apart(&mut self, [a, b, c]: [u32; 3]) -> u8 {
        let triangle = match self.next {
            next if b == next => [b, c, a],
            next if c == next => [c, a, b],
            _ => [a, b, c],
        };
        let [a, b, c] = triangle;
        // A primitive that begins: its numbers begin again.
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
            Some(at) if first == 0 && !reset => at,
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
        self.recent.push_edge([b, a]);
        self.recent.push_edge([c, b]);
        self.recent.push_edge([a, c]);
        (15 << 4 | code) as u8
    }

    /// The code of a corner: 0 a fresh index, 15 a free one, else a recent one.
    fn corner(&mut self, v: u32) -> usize {
        match age_of(&self.recent, v) {
            Some(back) if back < 14 => back + 1,
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
    (0..15).find_map(|back| {
        let edge = recent.edge(back);
        let mut turned = [[a, b, c], [b, c, a], [c, a, b]].into_iter();
        turned.find(|t| [t[0], t[1]] == edge).map(|t| (back, t))
    })
}

/// Returns the age of a vertex (0: just seen).
fn age_of(recent: &Recent, v: u32) -> Option<usize> {
    (0..16).find(|&back| recent.vertex(back) == v)
}
