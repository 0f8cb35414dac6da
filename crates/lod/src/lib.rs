//! Continuous level-of-detail models and their replay against the reference.
//!
//! A [`Model`] is immutable and storable; what moves lives in its `Cursor`. [`AnyModel`] is the
//! closed list of models: a new one is one folder here and its line in `any.rs`.
//! [`verify`](verify()) compares any of them with the reference answer at every step; a
//! [`Reference`] also checks the facts stored with a collapse sequence.
//!
//! This package knows nothing of files, graphics devices or metrics: models list their arrays
//! ([`Array`]) and `lodc-formats` lays them out.

mod any;
pub mod baseline;
pub mod bytes;
mod difference;
pub mod interactive;
pub mod masking;
mod model;
pub mod plan;
pub mod speed;
mod storage;
mod strips;
#[cfg(test)]
mod testing;
mod verify;

pub use any::{AnyCursor, AnyModel, ModelKind};
pub use baseline::Baseline;
pub use interactive::Interactive;
pub use masking::Masking;
pub use model::{Array, BuildError, Changes, Model, Traffic};
pub use speed::Speed;
pub use storage::StorageCost;
pub use strips::{StripKind, StripOptions, StripPool, Strips};
pub use verify::{Check, Failure, Reference, TooMuchWork, VerifyOptions, first_difference, verify};
