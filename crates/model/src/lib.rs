//! Multiresolution models: structures that show a mesh at any LOD (level of detail; LOD *k* is the
//! mesh after the first *k* records of its collapse sequence). Here are the trait of models and the
//! types that it exchanges.
//!
//! A [`Model`] is immutable and storable; what moves is its [`Model::Cursor`]. A move reports the
//! triangles that it removes and adds to a [`Changes`]. What a model needs besides the mesh and the
//! collapse sequence is a list of [`Array`]s, which `lodc-formats` lays out in a file.
//!
//! ```
//! use lodc_mesh::OrientedTriangle;
//! use lodc_model::{Changes, report_difference};
//!
//! /// Counts what a move changes.
//! #[derive(Default)]
//! struct Count {
//!     removed: usize,
//!     added: usize,
//! }
//!
//! impl Changes for Count {
//!     fn removed(&mut self, _: OrientedTriangle) {
//!         self.removed += 1;
//!     }
//!     fn added(&mut self, _: OrientedTriangle) {
//!         self.added += 1;
//!     }
//! }
//!
//! let triangle = |corners| OrientedTriangle::new(0, corners);
//! let mut before = [triangle([0, 1, 2]), triangle([2, 1, 3])];
//! let mut after = [triangle([2, 1, 3])];
//! let mut count = Count::default();
//! report_difference(&mut before, &mut after, &mut count);
//! assert_eq!((count.removed, count.added), (1, 0));
//! ```

mod array;
pub mod bytes;
mod changes;
mod model;
mod storage;

pub use array::{Array, BuildError, Layout};
pub use changes::{Changes, Difference, report_difference};
pub use model::{Model, Traffic};
pub use storage::StorageCost;
