//! Interactive Meshes (thesis chapter 5): one word per vertex, `collapse_to`, on top of the mesh.
//!
//! Vertices are in collapse order and the triangles of a submesh in reverse order of their
//! disappearance, so a LOD is a prefix of each submesh's triangles with every vertex replaced by
//! what it has become. Nothing else is stored: the `collapse_to` list is the sequence's own
//! targets.

mod cursor;
mod extract;
mod index;
mod lists;
mod live;
mod many;
mod measure;
mod replay;
mod resident;
pub mod shaders;
#[cfg(test)]
mod tests;
mod tour;
pub mod view;

pub use cursor::Cursor;
pub use extract::Extraction;
pub use lists::{CollapseLists, ListsTooLong};
pub use live::Counting;
pub use many::{Move, ResidentMany};
pub use replay::Continuous;
pub use resident::{Resident, ResidentView};

use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use lodc_model::{Array, BuildError, Changes, Layout, Model, StorageCost, Traffic};
use std::sync::Arc;

/// An Interactive Mesh.
#[derive(Clone, Debug)]
pub struct Interactive {
    simplified: Arc<Simplified>,
    /// The LOD from which on each triangle is not drawn; never rising within a submesh.
    removal_lods: Vec<u32>,
}

impl Interactive {
    /// Makes the model. Near-linear in the mesh: the LOD at which each triangle dies is worked out
    /// once, so that the live prefix of a submesh is known at any LOD without searching.
    ///
    /// # Errors
    /// If the triangles of a submesh are not in reverse order of their disappearance.
    pub fn build(simplified: &Arc<Simplified>) -> Result<Self, BuildError> {
        let positions = simplified.mesh().position_ids();
        let removal_lods = lodc_mesh::removal_lods(simplified, &positions);
        for (submesh, s) in simplified.mesh().submeshes().iter().enumerate() {
            if let Some(i) =
                removal_lods[s.triangles()].windows(2).position(|pair| pair[0] < pair[1])
            {
                return Err(BuildError::TriangleOrder {
                    submesh,
                    triangle: s.first_triangle as usize + i + 1,
                });
            }
        }
        Ok(Self { simplified: Arc::clone(simplified), removal_lods })
    }

    /// Makes the model of what [`Model::arrays`] gave out: nothing, so this is [`Self::build`].
    ///
    /// # Errors
    /// If there are arrays, and as [`Self::build`].
    pub fn load(simplified: &Arc<Simplified>, arrays: &[Array]) -> Result<Self, BuildError> {
        if arrays.is_empty() {
            Self::build(simplified)
        } else {
            Err(BuildError::Arrays { given: arrays.iter().map(|a| a.name.clone()).collect() })
        }
    }

    /// Returns the target of each vertex but the last (thesis 5.2).
    #[must_use]
    pub fn collapse_to(&self) -> &[u32] {
        self.simplified.collapses().targets()
    }

    /// For each triangle the LOD from which on it is not drawn.
    #[must_use]
    pub fn removal_lods(&self) -> &[u32] {
        &self.removal_lods
    }

    /// Returns the number of triangles of a submesh that are drawn at `lod`: its first ones.
    #[must_use]
    pub fn live(&self, submesh: usize, lod: Lod) -> u32 {
        let triangles = self.simplified.mesh().submeshes()[submesh].triangles();
        self.removal_lods[triangles].partition_point(|&removal_lod| removal_lod > lod.0) as u32
    }
}

impl Model for Interactive {
    type Cursor = Cursor;

    fn name(&self) -> &'static str {
        "interactive"
    }
    fn simplified(&self) -> &Arc<Simplified> {
        &self.simplified
    }
    fn cursor(&self) -> Cursor {
        Cursor::new(&self.simplified, &self.removal_lods)
    }
    fn lod(&self, cursor: &Cursor) -> Lod {
        cursor.lod()
    }
    fn seek(&self, cursor: &mut Cursor, lod: Lod, changes: &mut impl Changes) -> Traffic {
        cursor.seek(&self.simplified, &self.removal_lods, lod, changes)
    }
    /// The number of the LOD: a GPU has the lists and does everything else by itself.
    fn sent(&self, _: Lod, _: Lod, traffic: Traffic) -> u64 {
        if traffic.records == 0 { 0 } else { 4 }
    }
    fn for_each_triangle(&self, cursor: &Cursor, see: impl FnMut(OrientedTriangle)) {
        cursor.for_each_triangle(&self.simplified, see);
    }
    fn drawn(&self, cursor: &Cursor) -> u64 {
        cursor.drawn()
    }
    /// `3v + 3f + L` words (eq. 5.2: 10·v for a closed mesh), `L` counting the records down to
    /// `lod`.
    fn storage_to(&self, lod: Lod) -> StorageCost {
        let plain = StorageCost::of_triangles(&self.simplified);
        let geometry = 12 * (plain.vertices + plain.fakes);
        let structures = 4 * u64::from(self.simplified.collapses().floor(lod).0);
        StorageCost { positions: geometry, normals: geometry, structures, ..plain }
    }
    fn arrays(&self, _: Layout) -> Vec<Array> {
        Vec::new()
    }
}
