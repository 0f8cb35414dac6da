//! The continuous extraction pass on the CPU (thesis 5.2.3, algorithm 5): every vertex moves along
//! its collapse list. The same on the CPU as `extract.wgsl`.

use super::CollapseLists;
use lodc_mesh::Lod;

/// A LOD as the extraction pass keeps it: for every vertex the *current collapse*, a pointer into
/// the collapse lists.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Extraction {
    lod: u32,
    current: Vec<u32>,
}

impl Extraction {
    /// LOD 0: every vertex shows itself.
    #[must_use]
    pub fn new(lists: &CollapseLists) -> Self {
        Self { lod: 0, current: lists.offsets()[..lists.vertices()].to_vec() }
    }

    /// Moves to `lod`, by the same loops in either direction. Only vertices below the larger of the
    /// two LODs are read, and of those only the ones whose entry changes are rewritten. The
    /// thesis's algorithm has no loop along the list: a jump over several collapses of one vertex
    /// would show the first of them. `rewrite` gets each vertex that is rewritten, and what is
    /// shown for it.
    pub fn seek(&mut self, lists: &CollapseLists, lod: Lod, mut rewrite: impl FnMut(u32, u32)) {
        let touched = self.lod.max(lod.0).min(lists.vertices() as u32);
        for v in 0..touched {
            let range = lists.range(v);
            let mut current = self.current[v as usize] as usize;
            while lists.entries()[current] < lod.0 && current + 1 < range.end {
                current += 1;
            }
            while current > range.start && lists.entries()[current - 1] >= lod.0 {
                current -= 1;
            }
            if self.current[v as usize] as usize != current {
                self.current[v as usize] = current as u32;
                rewrite(v, lists.entries()[current]);
            }
        }
        self.lod = lod.0;
    }

    /// The current collapse of every vertex, as an index into [`CollapseLists::entries`].
    #[must_use]
    pub fn pointers(&self) -> &[u32] {
        &self.current
    }

    /// Returns the vertex that is shown for `vertex`.
    #[must_use]
    pub fn shown(&self, lists: &CollapseLists, vertex: u32) -> u32 {
        lists.entries()[self.current[vertex as usize] as usize]
    }
}
