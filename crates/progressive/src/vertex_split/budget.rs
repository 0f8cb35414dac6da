//! Bounds on the memory and work that a stream may ask for, in proportion to its bytes.

/// The size and work of an object so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cost {
    /// Memory, in units of about four bytes: one for each channel of each vertex, plus 8 for each
    /// vertex and each triangle.
    pub(crate) size: u64,
    /// Time: triangles and groups visited.
    pub(crate) work: u64,
}

impl Cost {
    /// The larger size and the larger work of two costs.
    pub(crate) fn max(self, other: Self) -> Self {
        Self { size: self.size.max(other.size), work: self.work.max(other.work) }
    }

    /// Returns whether a stream of `bytes` bytes may cost this much: a size of 2^20 and 1,024 for
    /// each byte, and work of 2^26 and 2^16 for each byte. Real streams take a hundredth of that;
    /// without a bound a few bytes could ask for any amount of memory and time.
    pub(crate) fn is_within_budget(self, bytes: usize) -> bool {
        let bytes = bytes as u64;
        let bound = |base: u64, per_byte: u64| base.saturating_add(bytes.saturating_mul(per_byte));
        self.size <= bound(1 << 20, 1024) && self.work <= bound(1 << 26, 1 << 16)
    }
}
