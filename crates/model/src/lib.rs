//! What every multiresolution model is: the traits of models and cursors, and what they exchange.
//!
//! A [`Model`] is immutable and storable; what moves is its [`Model::Cursor`]. A move reports the
//! triangles that it removes and adds to a [`Changes`]. What a model needs besides the mesh and the
//! collapse sequence is a list of [`Array`]s, which `lodc-formats` lays out in a file.

mod array;
pub mod bytes;
mod changes;
mod model;
mod storage;

pub use array::{Array, BuildError};
pub use changes::{Changes, Difference, report_difference};
pub use model::{Model, Traffic};
pub use storage::StorageCost;
