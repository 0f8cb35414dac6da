//! A hash table that numbers distinct keys in order of first appearance: how corners with equal
//! indices become one vertex.

/// An open-addressing table over keys that are kept elsewhere. Its hash is seeded from the file's
/// content, so that no file can be made to collide; the numbering does not depend on it.
#[derive(Debug)]
pub(super) struct Unique {
    /// Numbers of keys, or [`EMPTY`]; its length is a power of two.
    table: Vec<u32>,
    /// Slots that are not empty.
    used: usize,
    seed: u64,
}

/// Stands for a slot without a number.
const EMPTY: u32 = u32::MAX;
/// Slots of a table without keys. Chosen by hand: small, since most submeshes need few.
const FIRST_SLOTS: usize = 64;

impl Unique {
    /// An empty table.
    pub(super) fn new(seed: u64) -> Self {
        Self { table: vec![EMPTY; FIRST_SLOTS], used: 0, seed }
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.table.clear();
        self.table.resize(FIRST_SLOTS, EMPTY);
        self.used = 0;
    }

    /// The number of `key`; a new key gets the number `next`. `key_of` returns the key of an
    /// earlier number.
    pub(super) fn number(
        &mut self,
        key: [u32; 3],
        next: u32,
        key_of: impl Fn(u32) -> [u32; 3],
    ) -> u32 {
        if self.used * 3 >= self.table.len() * 2 {
            let old = std::mem::take(&mut self.table);
            self.table.resize(old.len() * 2, EMPTY);
            for id in old.into_iter().filter(|&id| id != EMPTY) {
                let slot = self.slot(key_of(id), |_| false);
                self.table[slot] = id;
            }
        }
        let slot = self.slot(key, |id| key_of(id) == key);
        if self.table[slot] == EMPTY {
            self.table[slot] = next;
            self.used += 1;
        }
        self.table[slot]
    }

    /// The slot that has `key` (whose number satisfies `same`), or an empty one for it.
    fn slot(&self, key: [u32; 3], same: impl Fn(u32) -> bool) -> usize {
        let mask = self.table.len() - 1;
        let mut slot = self.hash(key) & mask;
        while self.table[slot] != EMPTY && !same(self.table[slot]) {
            slot = (slot + 1) & mask;
        }
        slot
    }

    /// Mixes a key as SplitMix64 mixes its state.
    fn hash(&self, key: [u32; 3]) -> usize {
        let mix = |x: u64| {
            let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            x ^ (x >> 31)
        };
        let first = mix(self.seed ^ (u64::from(key[0]) | u64::from(key[1]) << 32));
        mix(first.wrapping_add(u64::from(key[2]).wrapping_mul(0x9e37_79b9_7f4a_7c15))) as usize
    }
}

/// For each of `count` keys, the first number with the same key.
pub(crate) fn first_equal(count: usize, seed: u64, key_of: impl Fn(u32) -> [u32; 3]) -> Vec<u32> {
    let mut unique = Unique::new(seed);
    (0..count as u32).map(|i| unique.number(key_of(i), i, &key_of)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    #[test]
    fn keys_are_numbered_as_they_come_whatever_the_seed() {
        let mut random = Random(3);
        let keys: Vec<[u32; 3]> = (0..5000)
            .map(|_| [random.below(9) as u32, random.below(9) as u32, random.below(9) as u32])
            .collect();
        let naive: Vec<u32> = keys
            .iter()
            .map(|k| keys.iter().position(|other| other == k).expect("itself") as u32)
            .collect();
        for seed in [0, 1, u64::MAX] {
            assert_eq!(first_equal(keys.len(), seed, |i| keys[i as usize]), naive);
        }
        assert!(first_equal(0, 0, |_| [0; 3]).is_empty());
    }
}
