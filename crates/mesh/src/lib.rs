//! The data types that all stages of lodc exchange, with few algorithms.
//!
//! A [`Mesh`] is what an importer makes. A simplifier turns it into a [`Simplified`]: the same mesh
//! in collapse order (the order in which vertices disappear) with a [`CollapseSequence`]. Models,
//! files and tests read that. [`Simplified::triangles_at`] is the reference: everything else must
//! show the same triangles.
//!
//! Terms (vertex, position, wedge group, record, step, LOD) are defined in `docs/GLOSSARY.md`.
//!
//! ```
//! use lodc_mesh::{Lod, Mesh, MeshParts, Submesh};
//!
//! // Two triangles of one submesh.
//! let mesh = Mesh::try_from(MeshParts {
//!     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
//!     vertex_submesh: vec![0; 4],
//!     attributes: vec![],
//!     triangles: vec![[0, 1, 2], [0, 2, 3]],
//!     submeshes: vec![Submesh { first_triangle: 0, triangle_count: 2, attributes: vec![] }],
//! })?;
//! // Any sequence of collapses will do here; a simplifier makes better ones.
//! let simplified = lodc_fixtures::random_collapse(&mesh, 1);
//! let coarser = simplified.collapses().lod_for_triangles(1);
//! assert_eq!(simplified.triangles_at(Lod(0)).len(), 2);
//! assert!(simplified.triangles_at(coarser).len() <= 1);
//! # Ok::<(), lodc_mesh::MeshError>(())
//! ```

mod arrange;
mod attribute;
mod border;
mod chain;
mod clean;
mod csr;
mod disjoint;
mod extract;
mod floor;
mod groups;
mod leb128;
mod mesh;
mod motion;
mod multiset;
mod pose_key;
mod position;
mod primitive;
mod random;
mod removal;
mod sequence;
mod shortcuts;
mod simplified;
mod submesh;
mod weld;

pub use attribute::{Attribute, Component, Semantic};
pub use chain::{Chain, LevelTriangles, MorphingChain};
pub use clean::Cleaning;
pub use csr::Csr;
pub use disjoint::DisjointSets;
pub use floor::floor;
pub use groups::WedgeGroups;
pub use leb128::{put_leb128, take_leb128};
pub use mesh::{Mesh, MeshError, MeshParts};
pub use multiset::{OrientedTriangle, TriangleHash};
pub use pose_key::PoseKey;
pub use position::{PositionIds, position_key};
pub use primitive::{NONE, is_degenerate};
pub use random::SplitMix64;
pub use removal::removal_lods;
pub use sequence::{CollapseSequence, Lod, SequenceError, SequenceParts, Step};
pub use shortcuts::Shortcuts;
pub use simplified::{Simplified, SimplifiedError};
pub use submesh::Submesh;
pub use weld::weld_positions;
