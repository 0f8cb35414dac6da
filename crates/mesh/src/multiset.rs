//! Comparing meshes as multisets of oriented triangles: exactly, and by an order-independent hash.

use crate::SplitMix64;

/// A triangle of a submesh whose corners are rotated so that the smallest comes first. Two are
/// equal exactly if they are the same triangle with the same orientation. (The corners must be
/// different vertices; those of live triangles are.)
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OrientedTriangle {
    /// The submesh.
    pub submesh: u32,
    /// The corners, counter-clockwise, smallest first.
    pub corners: [u32; 3],
}

impl OrientedTriangle {
    /// Rotates the corners into canonical order.
    #[must_use]
    #[inline]
    pub fn new(submesh: u32, [a, b, c]: [u32; 3]) -> Self {
        let corners = if a <= b && a <= c {
            [a, b, c]
        } else if b <= a && b <= c {
            [b, c, a]
        } else {
            [c, a, b]
        };
        Self { submesh, corners }
    }
}

/// A multiset of oriented triangles as the wrapping sum of their 128-bit hashes: triangles can be
/// added and taken away in any order. Equal multisets have equal sums; unequal ones collide with
/// probability 2⁻¹²⁸ or so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TriangleHash(u128);

impl TriangleHash {
    /// Adds a triangle.
    #[inline]
    pub fn add(&mut self, t: OrientedTriangle) {
        self.0 = self.0.wrapping_add(hash(t));
    }
    /// Takes a triangle away.
    #[inline]
    pub fn remove(&mut self, t: OrientedTriangle) {
        self.0 = self.0.wrapping_sub(hash(t));
    }
}

impl FromIterator<OrientedTriangle> for TriangleHash {
    fn from_iter<I: IntoIterator<Item = OrientedTriangle>>(triangles: I) -> Self {
        let mut sum = Self::default();
        triangles.into_iter().for_each(|t| sum.add(t));
        sum
    }
}

/// Three rounds of a Feistel network (Luby and Rackoff 1988) around [`SplitMix64::mix`]: a
/// bijection, so that two triangles never have one hash.
#[inline]
fn hash(t: OrientedTriangle) -> u128 {
    let mut a = u64::from(t.submesh) << 32 | u64::from(t.corners[0]);
    let mut b = u64::from(t.corners[1]) << 32 | u64::from(t.corners[2]);
    // The keys are the first 192 bits of the fraction of π, as good as any.
    b ^= SplitMix64::mix(a ^ 0x243f_6a88_85a3_08d3);
    a ^= SplitMix64::mix(b ^ 0x1319_8a2e_0370_7344);
    b ^= SplitMix64::mix(a ^ 0xa409_3822_299f_31d0);
    u128::from(a) << 64 | u128::from(b)
}
