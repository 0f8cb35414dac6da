//! Positions as identities: compared bit for bit, with −0 and +0 the same, and numbered. Vertices
//! that part in motion are at different ones, wherever they are at rest.

use crate::motion::MotionStreams;
use std::ops::Range;

/// The identity of a position at rest: two vertices are at one exactly if their keys are equal.
#[must_use]
pub fn position_key(p: [f32; 3]) -> [u32; 3] {
    // Adding +0 turns −0 into +0 and leaves every other value as it is.
    p.map(|c| (c + 0.0).to_bits())
}

/// Every vertex's position, numbered in order of first appearance.
#[derive(Clone, Debug)]
pub struct PositionIds {
    /// The position of each vertex.
    pub of_vertex: Vec<u32>,
    /// The first vertex at each position.
    pub first_vertex: Vec<u32>,
}

impl PositionIds {
    /// Numbers the positions of the vertices of a mesh with these streams: two vertices are at one
    /// position if they are at rest and in motion, as their morph targets' deltas, joints and
    /// weights are equal, too.
    pub(crate) fn in_motion(positions: &[[f32; 3]], streams: &MotionStreams<'_>) -> Self {
        let at_rest = Self::new(positions);
        if streams.is_empty() || at_rest.len() == positions.len() {
            return at_rest;
        }
        at_rest.parted(streams)
    }

    /// Gives vertices at one position that move differently different numbers.
    fn parted(&self, streams: &MotionStreams<'_>) -> Self {
        let mut counts = vec![0u32; self.len()];
        self.of_vertex.iter().for_each(|&p| counts[p as usize] += 1);
        // Only where a position has several vertices are their keys compared: for each of these the
        // position, the range of its key in `keys`, and the vertex.
        let (mut keys, mut shared) = (Vec::new(), Vec::new());
        for (&position, vertex) in self.of_vertex.iter().zip(0u32..) {
            if counts[position as usize] > 1 {
                let start = keys.len();
                streams.put_key(vertex, &mut keys);
                shared.push((position, start..keys.len(), vertex));
            }
        }
        shared.sort_unstable_by(|a, b| {
            let key = |range: &Range<usize>| &keys[range.clone()];
            a.0.cmp(&b.0).then_with(|| key(&a.1).cmp(key(&b.1))).then(a.2.cmp(&b.2))
        });
        let mut first_equal: Vec<u32> = (0..index(self.of_vertex.len())).collect();
        for pair in shared.windows(2) {
            if pair[0].0 == pair[1].0 && keys[pair[0].1.clone()] == keys[pair[1].1.clone()] {
                first_equal[pair[1].2 as usize] = first_equal[pair[0].2 as usize];
            }
        }
        Self::by_first(&first_equal)
    }

    /// Numbers the positions of some vertices at rest, in linear time: this runs on every mesh.
    #[must_use]
    pub fn new(positions: &[[f32; 3]]) -> Self {
        Self::by_hashing(positions).unwrap_or_else(|| Self::by_sorting(positions))
    }

    /// Returns the numbers, rising, of triangles without duplicates: of triangles with the same
    /// three positions, in any order, only the first.
    #[must_use]
    pub fn distinct(&self, triangles: &[[u32; 3]]) -> Vec<u32> {
        let positions = |t: &[u32; 3]| {
            let mut positions = t.map(|v| self.of_vertex[v as usize]);
            positions.sort_unstable();
            positions
        };
        let mut by_positions: Vec<([u32; 3], u32)> =
            triangles.iter().map(positions).zip(0..).collect();
        by_positions.sort_unstable();
        by_positions.dedup_by_key(|(positions, _)| *positions);
        let mut firsts: Vec<u32> = by_positions.into_iter().map(|(_, number)| number).collect();
        firsts.sort_unstable();
        firsts
    }

    /// Numbers positions with a hash table (open addressing). `None` if far more slots had to be
    /// searched than chance explains: positions made to collide would take quadratic time.
    fn by_hashing(positions: &[[f32; 3]]) -> Option<Self> {
        const EMPTY: u32 = u32::MAX;
        // Chosen by hand: far more than the few probes for each position that chance causes.
        let mut probes_remaining = 16 * positions.len() + 1024;
        let slots = (positions.len() * 3 / 2 + 1).next_power_of_two();
        let mask = slots - 1;
        let mut table = vec![EMPTY; slots];
        let mut of_vertex = Vec::with_capacity(positions.len());
        let mut first_vertex: Vec<u32> = Vec::new();
        for (vertex, &p) in positions.iter().enumerate() {
            let key = position_key(p);
            let mut slot = hash(key) & mask;
            let id = loop {
                let id = table[slot];
                if id == EMPTY {
                    let id = index(first_vertex.len());
                    table[slot] = id;
                    first_vertex.push(index(vertex));
                    break id;
                }
                if position_key(positions[first_vertex[id as usize] as usize]) == key {
                    break id;
                }
                slot = (slot + 1) & mask;
                probes_remaining = probes_remaining.checked_sub(1)?;
            };
            of_vertex.push(id);
        }
        Some(Self { of_vertex, first_vertex })
    }

    /// Returns the same numbers in O(n log n), whatever the positions.
    fn by_sorting(positions: &[[f32; 3]]) -> Self {
        let mut order: Vec<u32> = (0..index(positions.len())).collect();
        let key = |v: u32| position_key(positions[v as usize]);
        order.sort_unstable_by_key(|&v| (key(v), v));
        let mut first_equal: Vec<u32> = (0..index(positions.len())).collect();
        for pair in order.windows(2) {
            if key(pair[0]) == key(pair[1]) {
                first_equal[pair[1] as usize] = first_equal[pair[0] as usize];
            }
        }
        Self::by_first(&first_equal)
    }

    /// Returns the numbers, given for each vertex the first one at its position.
    fn by_first(first_equal: &[u32]) -> Self {
        let (mut of_vertex, mut first_vertex) = (vec![0; first_equal.len()], Vec::new());
        for (v, &first) in first_equal.iter().enumerate() {
            if first as usize == v {
                of_vertex[v] = index(first_vertex.len());
                first_vertex.push(first);
            } else {
                of_vertex[v] = of_vertex[first as usize];
            }
        }
        Self { of_vertex, first_vertex }
    }

    /// Number of different positions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.first_vertex.len()
    }

    /// Returns whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.first_vertex.is_empty()
    }
}

fn index(i: usize) -> u32 {
    u32::try_from(i).expect("a mesh has fewer than 2^32 vertices")
}

fn hash(key: [u32; 3]) -> usize {
    let mut h = u64::from(key[0]) | u64::from(key[1]) << 32;
    h = (h ^ u64::from(key[2]).wrapping_mul(0x9e37_79b9_7f4a_7c15))
        .wrapping_mul(0xff51_afd7_ed55_8ccd);
    h ^= h >> 32;
    h = h.wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    (h ^ (h >> 29)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_fixtures::Rng;

    #[test]
    fn positions_made_to_collide_are_numbered_by_sorting() {
        // x and y are chosen for each z so that all hashes are equal: each position would be
        // compared with all before it.
        let mut rng = Rng::new(10);
        let mut positions = Vec::new();
        while positions.len() < 20_000 {
            let z = rng.unit();
            let mixed =
                0x3f80_0000_3f80_0000 ^ u64::from(z.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let p = [f32::from_bits(mixed as u32), f32::from_bits((mixed >> 32) as u32), z];
            if p.iter().all(|c| c.is_finite()) {
                positions.push(p);
            }
        }
        let hashes = |i: usize| hash(position_key(positions[i]));
        assert!((1..positions.len()).all(|i| hashes(i) == hashes(0)));
        assert!(PositionIds::by_hashing(&positions).is_none(), "too many probes");
        // In any order, and some twice.
        let twice: Vec<_> = positions.iter().chain(positions.iter().rev()).copied().collect();
        let ids = PositionIds::new(&twice);
        let mut first = std::collections::BTreeMap::new();
        for (vertex, p) in twice.iter().enumerate() {
            let next = first.len() as u32;
            assert_eq!(ids.of_vertex[vertex], *first.entry(position_key(*p)).or_insert(next));
        }
        assert_eq!(ids.len(), first.len());
    }
}
