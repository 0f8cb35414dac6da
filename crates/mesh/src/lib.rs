//! The vocabulary of lodc: what every stage exchanges, and almost no algorithms.
//!
//! A [`Mesh`] is what an importer makes. A simplifier turns it into a [`Simplified`]: the same mesh in collapse order
//! with a [`CollapseSequence`]. Models, files and tests read that. [`Simplified::triangles_at`] is the reference
//! answer against which everything else is judged.
//!
//! Terms (vertex, position, wedge group, record, step, LOD) are defined in `docs/GLOSSARY.md`.

mod attribute;
mod clean;
mod extract;
mod groups;
mod mesh;
mod multiset;
mod position;
mod sequence;
mod simplified;
mod weld;

pub use attribute::{Attribute, Component, Semantic};
pub use clean::Cleaning;
pub use groups::WedgeGroups;
pub use mesh::{Mesh, MeshError, MeshParts, Submesh};
pub use multiset::{OrientedTriangle, TriangleHash};
pub use position::{PositionIds, position_key};
pub use sequence::{CollapseSequence, Lod, SequenceError, SequenceParts, Step};
pub use simplified::{Simplified, SimplifiedError};
pub use weld::weld_positions;
