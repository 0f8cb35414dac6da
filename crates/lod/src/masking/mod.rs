//! Masking Strips (thesis chapter 4): strips of constant length, of which every level of detail
//! draws a filtered copy.
//!
//! Record *k* of a collapse sequence removes vertex *k*, which becomes its target; a step is the
//! records of one collapse. A strip has an *entry* for each record that changes it, with two masks
//! of a bit for each position of the strip. The *position mask* says which positions hold the
//! removed vertex; they get its target. The *filter mask* says which positions are drawn
//! afterwards: the fewest that draw exactly the live triangles of the strip. Filters do not depend
//! on each other, so a far jump needs only the last one of each strip, and undoing an entry brings
//! back the filter of the entry before. A strip without live triangles has no further entries.
//!
//! Both masks fit into one word: strips of more than 16 vertices are cut. Everything but the strips
//! follows from them and the collapse sequence, so that nothing else is stored in a file. In memory
//! it is there twice: strip by strip for jumps, and by record for near moves.

mod cursor;
mod filters;
mod history;
mod info;
mod measure;
mod pattern;
mod replay;
mod shortest;
#[cfg(test)]
mod tests;
mod trim;
mod updates;

pub use cursor::Cursor;
pub use info::{InfoStrip, InfoUpdate};
pub use replay::SHADERS;

use crate::cut::cut_long;
use crate::stored_strips::{STRIPS, from_array, to_array};
use history::Entry;
use lodc_mesh::{Lod, NONE, OrientedTriangle, PositionIds, Simplified};
use lodc_model::{Array, BuildError, Changes, Layout, Model, StorageCost, Traffic};
use lodc_strip::{Strips, restart_list};
use pattern::LONGEST;
use std::sync::Arc;
use updates::Updates;

/// Masking Strips of a mesh.
#[derive(Clone, Debug)]
pub struct Masking {
    simplified: Arc<Simplified>,
    strips: Arc<Strips>,
    positions: PositionIds,
    /// The submesh of each strip.
    submeshes: Vec<u32>,
    /// Start of each strip's entries in `entries`, and end of the last one's.
    entry_starts: Vec<u32>,
    /// Strip by strip, in order of records.
    entries: Vec<Entry>,
    /// For each strip the first LOD at which it draws nothing.
    removal_lods: Vec<u32>,
    /// The updates of `entries` by record, for moves of few records.
    updates: Updates,
}

impl Masking {
    /// The most vertices that a strip may have, so that its two masks are one word. [`Self::build`]
    /// cuts longer ones.
    pub const LONGEST_STRIP: usize = LONGEST;

    /// Makes the model from strips that draw the mesh of LOD 0. Parallel over strips; the same
    /// whatever the threads.
    ///
    /// # Errors
    /// If the sequence changes strips so often that the model would be far larger than the mesh
    /// ([`BuildError::Malformed`]): no sequence of a simplifier does.
    pub fn build(simplified: &Arc<Simplified>, strips: Arc<Strips>) -> Result<Self, BuildError> {
        let strips = cut_long(strips, Self::LONGEST_STRIP);
        let positions = simplified.mesh().position_ids();
        let histories = history::histories(simplified, &strips, &positions).ok_or_else(|| {
            BuildError::Malformed {
                array: STRIPS,
                what: "would need far more updates than it has vertices".to_owned(),
            }
        })?;
        let lengths: Vec<_> = strips.iter().map(<[u32]>::len).collect();
        let updates = Updates::new(&histories, &lengths, simplified.collapses().targets());
        let removal_lod = |range: &[u32]| {
            let last = histories.entries[range[0] as usize..range[1] as usize].last();
            last.filter(|entry| entry.filter == 0).map_or(NONE, |entry| entry.record + 1)
        };
        Ok(Self {
            simplified: Arc::clone(simplified),
            removal_lods: histories.entry_starts.windows(2).map(removal_lod).collect(),
            submeshes: strips.submeshes().collect(),
            strips,
            positions,
            entry_starts: histories.entry_starts,
            entries: histories.entries,
            updates,
        })
    }

    /// Makes the model of what [`Model::arrays`] gave out: the strips.
    ///
    /// # Errors
    /// If the array is damaged, has a strip of more than [`Self::LONGEST_STRIP`] vertices or is not
    /// the only one; and as [`Self::build`].
    pub fn load(simplified: &Arc<Simplified>, arrays: &[Array]) -> Result<Self, BuildError> {
        let [array] = arrays else {
            return Err(BuildError::Arrays {
                given: arrays.iter().map(|a| a.name.clone()).collect(),
            });
        };
        if array.name != STRIPS {
            return Err(BuildError::Arrays { given: vec![array.name.clone()] });
        }
        let strips = from_array(array, simplified.mesh())?;
        if strips.iter().any(|strip| strip.len() > Self::LONGEST_STRIP) {
            let what = format!("has a strip of more than {} vertices", Self::LONGEST_STRIP);
            return Err(BuildError::Malformed { array: STRIPS, what });
        }
        Self::build(simplified, Arc::new(strips))
    }

    /// The strips at LOD 0, none longer than [`Self::LONGEST_STRIP`].
    #[must_use]
    pub fn strips(&self) -> &Arc<Strips> {
        &self.strips
    }

    /// Returns the range of a strip's entries.
    fn history(&self, strip: usize) -> std::ops::Range<usize> {
        self.entry_starts[strip] as usize..self.entry_starts[strip + 1] as usize
    }
}

impl Model for Masking {
    type Cursor = Cursor;

    fn name(&self) -> &'static str {
        "masking"
    }
    fn simplified(&self) -> &Arc<Simplified> {
        &self.simplified
    }
    fn cursor(&self) -> Cursor {
        Cursor::new(self)
    }
    fn lod(&self, cursor: &Cursor) -> Lod {
        cursor.lod()
    }
    fn seek(&self, cursor: &mut Cursor, lod: Lod, changes: &mut impl Changes) -> Traffic {
        cursor.seek(self, lod, changes)
    }
    fn for_each_triangle(&self, cursor: &Cursor, mut see: impl FnMut(OrientedTriangle)) {
        (0..self.strips.len()).for_each(|strip| cursor.drawn_by(self, strip).for_each(&mut see));
    }
    fn drawn(&self, cursor: &Cursor) -> u64 {
        cursor.drawn()
    }
    fn strip_list(&self, cursor: &Cursor) -> Option<Vec<u32>> {
        Some(restart_list((0..self.strips.len()).map(|strip| cursor.strip(strip))))
    }
    /// Strips, 1¼ words a record, and for each strip that a record changes one word and two masks
    /// of `⌈length / 8⌉` bytes; the entry that ends a strip is the word alone.
    fn storage_to(&self, lod: Lod) -> StorageCost {
        info::storage(self, self.simplified.collapses().floor(lod))
    }
    fn arrays(&self, layout: Layout) -> Vec<Array> {
        vec![to_array(&self.strips, self.simplified.mesh().vertex_count(), layout)]
    }
}
