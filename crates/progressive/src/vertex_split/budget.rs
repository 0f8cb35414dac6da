//! Bounds on the memory and work that a stream may ask for, in proportion to its bytes.

/// The size and work of an object so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cost {
    /// Indices of all channels of all vertices, plus 8 for each vertex and each triangle.
    pub(crate) size: u64,
    /// Triangles visited.
    pub(crate) work: u64,
}

impl Cost {
    /// Returns whether `bytes` of a stream may cost this much: 2^20 and 1,024 for each byte of
    /// size, 2^26 and 2^16 for each byte of work. Real streams take a hundredth of it; without a
    /// bound a few bytes could ask for any amount of memory and time.
    pub(crate) fn is_within_budget(self, bytes: usize) -> bool {
        let bytes = bytes as u64;
        let bound = |base: u64, each: u64| base.saturating_add(bytes.saturating_mul(each));
        self.size <= bound(1 << 20, 1024) && self.work <= bound(1 << 26, 1 << 16)
    }
}
