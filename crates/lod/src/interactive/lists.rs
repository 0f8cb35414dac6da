//! The construction pass on the CPU (thesis 5.2.2): makes each vertex's collapse list from
//! `collapse_to` when a model is loaded. The same on the CPU as `lists_length.wgsl` and
//! `lists_fill.wgsl`.

use lodc_mesh::Lod;
use std::ops::Range;

/// For every vertex what it is, what it becomes, what that becomes, and so on, one list behind the
/// other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CollapseLists {
    /// Start of each vertex's list in `entries`, and end of the last one.
    offsets: Vec<u32>,
    /// The lists. The first entry of each is the vertex itself.
    entries: Vec<u32>,
}

impl CollapseLists {
    /// Makes the lists for LODs down to `coarsest`: each ends with its first entry of at least that
    /// number. `last()` of the sequence gives the whole lists; a program that never shows coarse
    /// LODs saves most of their size (the thesis's 5·v holds down to 95 % of the vertices).
    ///
    /// # Errors
    /// If all lists together would have more than `max_entries` entries, or 2³². Lists of real
    /// meshes have fewer than ten entries on average, but a sequence can be made for which they
    /// grow with the square of its length.
    pub fn new(
        collapse_to: &[u32],
        coarsest: Lod,
        max_entries: usize,
    ) -> Result<Self, ListsTooLong> {
        let is_last = |v: usize| v >= collapse_to.len() || v >= coarsest.0 as usize;
        let length = Self::lengths(collapse_to, coarsest);
        let total: u64 = length.iter().map(|&l| u64::from(l)).sum();
        if total > (max_entries as u64).min(u64::from(u32::MAX)) {
            return Err(ListsTooLong { entries: total });
        }
        let mut offsets = Vec::with_capacity(length.len() + 1);
        offsets.push(0);
        let mut end = 0;
        offsets.extend(length.iter().map(|&l| {
            end += l;
            end
        }));
        let mut entries = vec![0; end as usize];
        for v in (0..length.len()).rev() {
            let first = offsets[v] as usize;
            entries[first] = v as u32;
            if !is_last(v) {
                let target = collapse_to[v] as usize;
                entries
                    .copy_within(offsets[target] as usize..offsets[target + 1] as usize, first + 1);
            }
        }
        Ok(Self { offsets, entries })
    }

    /// Returns the length of every vertex's list for LODs down to `coarsest`, without making the
    /// lists.
    #[must_use]
    pub fn lengths(collapse_to: &[u32], coarsest: Lod) -> Vec<u32> {
        let mut length = vec![1u32; collapse_to.len() + 1];
        for v in (0..collapse_to.len().min(coarsest.0 as usize)).rev() {
            length[v] = 1 + length[collapse_to[v] as usize];
        }
        length
    }

    /// Number of vertices.
    #[must_use]
    pub fn vertices(&self) -> usize {
        self.offsets.len() - 1
    }
    /// Returns the start of each list and the end of the last one: one more than there are
    /// vertices.
    #[must_use]
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }
    /// All lists, one behind the other.
    #[must_use]
    pub fn entries(&self) -> &[u32] {
        &self.entries
    }
    /// Returns the range of a vertex's list in [`Self::entries`].
    #[must_use]
    pub fn range(&self, vertex: u32) -> Range<usize> {
        self.offsets[vertex as usize] as usize..self.offsets[vertex as usize + 1] as usize
    }
    /// A vertex's list: itself, then what it becomes one collapse after the other. (The thesis
    /// prints lists without the vertex itself.)
    #[must_use]
    pub fn list(&self, vertex: u32) -> &[u32] {
        &self.entries[self.range(vertex)]
    }
}

/// Why collapse lists were not made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the collapse lists would have {entries} entries")]
pub struct ListsTooLong {
    /// Number of entries they would have.
    pub entries: u64,
}
