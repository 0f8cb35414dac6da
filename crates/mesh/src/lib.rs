//! The vocabulary of lodc: what every stage exchanges, and almost no algorithms.
//!
//! A [`Mesh`] is what an importer makes. A simplifier turns it into a [`Simplified`]: the same mesh
//! in collapse order with a [`CollapseSequence`]. Models, files and tests read that.
//! [`Simplified::triangles_at`] is the reference answer against which everything else is judged.
//!
//! Terms (vertex, position, wedge group, record, step, LOD) are defined in `docs/GLOSSARY.md`.

mod arrange;
mod attribute;
mod chain;
mod clean;
mod csr;
mod disjoint;
mod extract;
mod groups;
mod leb128;
mod mesh;
mod multiset;
mod position;
mod primitive;
mod random;
mod removal;
mod sequence;
mod shortcuts;
mod simplified;
mod weld;

pub use attribute::{Attribute, Component, Semantic};
pub use chain::{Chain, LevelTriangles};
pub use clean::Cleaning;
pub use csr::Csr;
pub use disjoint::DisjointSets;
pub use groups::WedgeGroups;
pub use leb128::{put_leb128, take_leb128};
pub use mesh::{Mesh, MeshError, MeshParts, Submesh};
pub use multiset::{OrientedTriangle, TriangleHash};
pub use position::{PositionIds, position_key};
pub use primitive::{NONE, is_degenerate};
pub use random::SplitMix64;
pub use removal::removal_lods;
pub use sequence::{CollapseSequence, Lod, SequenceError, SequenceParts, Step};
pub use shortcuts::Shortcuts;
pub use simplified::{Simplified, SimplifiedError};
pub use weld::weld_positions;
