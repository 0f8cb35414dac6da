//! Structures that models are measured against, over the same sequence (thesis tables 3.1 to 3.4,
//! 4.2, 4.3, 5.1).
//!
//! Baselines are models too and are held to the same reference, but they are never stored in a
//! file. [`Baseline`] is their closed list. Plain triangles and plain strips, which have no levels
//! of detail, are in [`StorageCost`]. [`Rebuild`] is what a far jump is measured against.
//!
//! ```
//! use lodc_lab::Baseline;
//! use lodc_mesh::Lod;
//! use lodc_model::Model;
//! use lodc_strip::{Effort, StripKind, Strips};
//! use std::sync::Arc;
//!
//! let simplified = Arc::new(lodc_fixtures::random_collapse(&lodc_fixtures::icosphere(2), 1));
//! let strips = Arc::new(Strips::generate(&simplified, StripKind::Stripe, Effort::Fast));
//! for baseline in Baseline::all(&simplified, &strips)? {
//!     let mut cursor = baseline.cursor();
//!     baseline.seek(&mut cursor, simplified.collapses().last(), &mut ());
//!     assert!(baseline.lod(&cursor) > Lod(0), "{}", baseline.name());
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod discrete;
mod lodstrips;
mod progressive_mesh;
mod rebuild;
#[cfg(test)]
mod tests;

pub use discrete::{Cursor as DiscreteCursor, Discrete, LEVELS};
pub use lodstrips::{Cursor as LodStripsCursor, LodStrips};
pub use progressive_mesh::{Cursor as ProgressiveMeshCursor, ProgressiveMesh};
pub use rebuild::Rebuild;

use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use lodc_model::{Array, BuildError, Changes, Layout, Model, StorageCost, Traffic};
use lodc_strip::Strips;
use std::sync::Arc;

/// A baseline of any kind.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Baseline {
    /// Progressive Meshes.
    ProgressiveMesh(ProgressiveMesh),
    /// `LodStrips`.
    LodStrips(LodStrips),
    /// Five discrete levels.
    Discrete(Discrete),
}

/// A cursor over a [`Baseline`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum BaselineCursor {
    /// Over Progressive Meshes.
    ProgressiveMesh(ProgressiveMeshCursor),
    /// Over `LodStrips`.
    LodStrips(LodStripsCursor),
    /// Over five discrete levels.
    Discrete(DiscreteCursor),
}

impl Baseline {
    /// All baselines, in the order in which reports list them, those made of strips over `strips`.
    ///
    /// # Errors
    /// If one cannot be made of this sequence.
    pub fn all(
        simplified: &Arc<Simplified>,
        strips: &Arc<Strips>,
    ) -> Result<Vec<Self>, BuildError> {
        let progressive = Self::ProgressiveMesh(ProgressiveMesh::build(simplified)?);
        let lodstrips = Self::LodStrips(LodStrips::build(simplified, Arc::clone(strips))?);
        Ok(vec![progressive, lodstrips, Self::Discrete(Discrete::build(simplified))])
    }

    /// Returns whether it shows every LOD.
    #[must_use]
    pub fn continuous(&self) -> bool {
        !matches!(self, Self::Discrete(_))
    }

    /// Bytes that the structure really holds, positions only, where that differs from what the
    /// thesis counts.
    #[must_use]
    pub fn tight_bytes(&self) -> Option<u64> {
        match self {
            Self::ProgressiveMesh(model) => Some(model.tight_bytes()),
            Self::LodStrips(model) => Some(model.tight_bytes()),
            Self::Discrete(_) => None,
        }
    }
}

/// Calls the same method of whichever baseline it is.
macro_rules! each {
    ($self:ident, $model:ident => $call:expr) => {
        match $self {
            Self::ProgressiveMesh($model) => $call,
            Self::LodStrips($model) => $call,
            Self::Discrete($model) => $call,
        }
    };
    ($self:ident, $cursor:expr, ($model:ident, $at:ident) => $call:expr) => {
        match ($self, $cursor) {
            (Self::ProgressiveMesh($model), BaselineCursor::ProgressiveMesh($at)) => $call,
            (Self::LodStrips($model), BaselineCursor::LodStrips($at)) => $call,
            (Self::Discrete($model), BaselineCursor::Discrete($at)) => $call,
            _ => panic!("a cursor of another baseline"),
        }
    };
}

impl Model for Baseline {
    type Cursor = BaselineCursor;

    fn name(&self) -> &'static str {
        each!(self, model => model.name())
    }
    fn simplified(&self) -> &Arc<Simplified> {
        each!(self, model => model.simplified())
    }
    fn cursor(&self) -> BaselineCursor {
        match self {
            Self::ProgressiveMesh(model) => BaselineCursor::ProgressiveMesh(model.cursor()),
            Self::LodStrips(model) => BaselineCursor::LodStrips(model.cursor()),
            Self::Discrete(model) => BaselineCursor::Discrete(model.cursor()),
        }
    }
    fn lod(&self, cursor: &BaselineCursor) -> Lod {
        each!(self, cursor, (model, at) => model.lod(at))
    }
    fn seek(&self, cursor: &mut BaselineCursor, lod: Lod, changes: &mut impl Changes) -> Traffic {
        each!(self, cursor, (model, at) => model.seek(at, lod, changes))
    }
    fn sent(&self, from: Lod, to: Lod, traffic: Traffic) -> u64 {
        each!(self, model => model.sent(from, to, traffic))
    }
    fn for_each_triangle(&self, cursor: &BaselineCursor, see: impl FnMut(OrientedTriangle)) {
        each!(self, cursor, (model, at) => model.for_each_triangle(at, see));
    }
    fn drawn(&self, cursor: &BaselineCursor) -> u64 {
        each!(self, cursor, (model, at) => model.drawn(at))
    }
    fn strip_list(&self, cursor: &BaselineCursor) -> Option<Vec<u32>> {
        each!(self, cursor, (model, at) => model.strip_list(at))
    }
    fn storage_to(&self, lod: Lod) -> StorageCost {
        each!(self, model => model.storage_to(lod))
    }
    fn arrays(&self, _: Layout) -> Vec<Array> {
        Vec::new()
    }
}
