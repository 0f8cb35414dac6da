//! A hash table from numbers in the whole mesh to numbers in a region, given in order of first
//! appearance.

use lodc_mesh::NONE;

/// A table from numbers of the whole mesh to those of a region, with open addressing and a fixed
/// hash: the same insertions give the same table.
pub(super) struct Table {
    keys: Vec<u32>,
    values: Vec<u32>,
    len: usize,
}

impl Table {
    /// A table for about that many entries without growing.
    pub(super) fn new(entries: usize) -> Self {
        let slots = (2 * entries.max(8)).next_power_of_two();
        Self { keys: vec![NONE; slots], values: vec![0; slots], len: 0 }
    }

    /// The slot of a key, or the free one where it belongs.
    #[inline]
    fn slot(&self, key: u32) -> usize {
        let mask = self.keys.len() - 1;
        // Fibonacci hashing: the factor is 2^64 divided by the golden ratio.
        let hash = u64::from(key).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut slot = (hash >> 32) as usize & mask;
        while self.keys[slot] != key && self.keys[slot] != NONE {
            slot = (slot + 1) & mask;
        }
        slot
    }

    #[inline]
    pub(super) fn get(&self, key: u32) -> Option<u32> {
        let slot = self.slot(key);
        (self.keys[slot] == key).then(|| self.values[slot])
    }

    /// The value of a key, which is `new` if the key was not there, and whether it was there.
    #[inline]
    pub(super) fn get_or_insert(&mut self, key: u32, new: u32) -> (u32, bool) {
        let slot = self.slot(key);
        if self.keys[slot] == key {
            return (self.values[slot], true);
        }
        (self.keys[slot], self.values[slot]) = (key, new);
        self.len += 1;
        if 2 * self.len > self.keys.len() {
            self.grow();
        }
        (new, false)
    }

    fn grow(&mut self) {
        let mut larger = Self::new(self.keys.len());
        for (&key, &value) in self.keys.iter().zip(&self.values).filter(|(k, _)| **k != NONE) {
            larger.get_or_insert(key, value);
        }
        *self = larger;
    }
}

#[cfg(test)]
mod tests {
    use super::Table;

    #[test]
    fn keys_keep_their_first_value_however_many_there_are() {
        let mut table = Table::new(4);
        for i in 0..1000u32 {
            assert_eq!(table.get(i * 7), None);
            assert_eq!(table.get_or_insert(i * 7, i), (i, false));
            assert_eq!(table.get_or_insert(i / 2 * 7, 5000), (i / 2, true));
        }
        assert!((0..1000).all(|i| table.get(i * 7) == Some(i)));
    }
}
