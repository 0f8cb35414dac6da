//! What every multiresolution model is: an immutable thing that cursors move over.

use crate::StorageCost;
use lodc_mesh::{Lod, OrientedTriangle, Simplified};
use std::{fmt, sync::Arc};

/// A multiresolution model of one mesh. It is immutable and storable; a cursor holds the current
/// LOD and whatever has to change with it.
///
/// At the end of every step, whichever way a cursor came there, a model shows exactly
/// [`Simplified::triangles_at`] that LOD.
pub trait Model {
    /// The moving part.
    type Cursor;

    /// What the model is called in options, files and reports.
    fn name(&self) -> &'static str;

    /// The mesh and the collapse sequence that this is a model of.
    fn simplified(&self) -> &Arc<Simplified>;

    /// A new cursor at LOD 0.
    fn cursor(&self) -> Self::Cursor;

    /// Where a cursor is: always the end of a step, or 0.
    fn lod(&self, cursor: &Self::Cursor) -> Lod;

    /// Moves a cursor to the LOD shown for `lod` (rounded down to the end of a step), finer or
    /// coarser, near or far. `changes` hears of exactly the triangles that go and come: no triangle
    /// that stays, none twice.
    fn seek(&self, cursor: &mut Self::Cursor, lod: Lod, changes: &mut impl Changes) -> Traffic;

    /// Bytes that a program which keeps the model on a GPU sends there for a move that cost
    /// `traffic`: each rewritten element by itself, unless a model says otherwise.
    fn sent(&self, _from: Lod, _to: Lod, traffic: Traffic) -> u64 {
        4 * traffic.rewritten
    }

    /// The triangles shown, in the order in which they would be drawn.
    fn triangles(&self, cursor: &Self::Cursor) -> Vec<OrientedTriangle>;

    /// How many indices are drawn: three for each triangle, or all those of the strips as they are
    /// now.
    fn drawn(&self, cursor: &Self::Cursor) -> u64;

    /// What storing the model takes.
    fn storage(&self) -> StorageCost {
        self.storage_to(self.simplified().collapses().last())
    }

    /// What storing it takes if LODs coarser than the one shown for `lod` are never wanted (thesis
    /// eq. 5.5 stops at 95 %).
    fn storage_to(&self, lod: Lod) -> StorageCost;

    /// What has to be stored besides the mesh and the sequence.
    fn arrays(&self) -> Vec<Array>;
}

/// Hears which triangles go and which come while a cursor moves.
pub trait Changes {
    /// Whether anybody listens. A model need not work out what nobody hears.
    const HEARD: bool = true;
    /// A triangle is not drawn any more.
    fn gone(&mut self, triangle: OrientedTriangle);
    /// A triangle is drawn from now on.
    fn came(&mut self, triangle: OrientedTriangle);
}

/// Hears nothing.
impl Changes for () {
    const HEARD: bool = false;
    fn gone(&mut self, _: OrientedTriangle) {}
    fn came(&mut self, _: OrientedTriangle) {}
}

/// What one move of a cursor cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Records that were passed.
    pub records: u32,
    /// Elements of the drawn data (vertices or indices) that were rewritten.
    pub rewritten: u64,
}

/// A named run of bytes that a model needs besides the mesh and the sequence. Numbers in it are
/// little-endian.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Array {
    /// Its name, unique within the model.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Why a model cannot be made of a sequence, or of what was stored.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// A triangle stands behind one that disappears before it.
    TriangleOrder {
        /// The submesh of both.
        submesh: usize,
        /// The triangle, as an index into the mesh.
        triangle: usize,
    },
    /// A stored array does not fit the mesh, the sequence or itself.
    Malformed {
        /// Name of the array.
        array: &'static str,
        /// What is wrong with it.
        what: String,
    },
    /// The stored arrays are not the ones that the model has.
    Arrays {
        /// Names of the arrays given.
        given: Vec<String>,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TriangleOrder { submesh, triangle } => {
                write!(
                    f,
                    "triangle {triangle} of submesh {submesh} stands behind one that disappears before it"
                )
            }
            Self::Malformed { array, what } => write!(f, "the array \"{array}\" {what}"),
            Self::Arrays { given } => {
                write!(f, "the model does not have the arrays [{}]", given.join(", "))
            }
        }
    }
}

impl std::error::Error for BuildError {}
