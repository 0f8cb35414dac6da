//! The three continuous level-of-detail models.
//!
//! [`AnyModel`] is the closed list of models: a new one is one folder here and its line in
//! `any.rs`. What a model is, [`Model`](lodc_model::Model) says; how one is verified,
//! `lodc-verify`.
//!
//! This package knows nothing of files, graphics devices or metrics: models list their arrays
//! ([`Array`](lodc_model::Array)) and `lodc-formats` lays them out; they describe their work on a
//! device as a [`Plan`](lodc_plan::Plan) and `lodc-gpu` runs it.

mod any;
pub mod interactive;
pub mod masking;
pub mod speed;
mod stored_strips;
pub mod trace;

pub use any::{AnyCursor, AnyModel, ModelKind};
pub use interactive::Interactive;
pub use masking::Masking;
pub use speed::Speed;
pub use stored_strips::check_submeshes;
