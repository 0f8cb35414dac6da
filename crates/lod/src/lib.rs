//! The three continuous level-of-detail models.
//!
//! [`AnyModel`] is the closed list of models: a new one is one folder here and its line in
//! `any.rs`. What a model is, [`Model`](lodc_model::Model) says; how one is verified,
//! `lodc-verify`.
//!
//! Which model: Interactive Meshes are made for a graphics device, which moves all vertices at once
//! and can show parts of one mesh at different levels. A processor that moves from frame to frame
//! takes Speed Strips, or Masking Strips where memory counts.
//!
//! This package knows nothing of files, graphics devices or metrics: models list their arrays
//! ([`Array`](lodc_model::Array)) and `lodc-formats` lays them out; they describe their work on a
//! device as a [`Plan`](lodc_plan::Plan) and `lodc-gpu` runs it.
//!
//! ```
//! use lodc_lod::{AnyModel, ModelKind};
//! use lodc_model::Model;
//! use lodc_strip::{StripOptions, StripPool};
//! use std::sync::Arc;
//!
//! let simplified = Arc::new(lodc_fixtures::random_collapse(&lodc_fixtures::icosphere(2), 1));
//! let mut strips = StripPool::new(&simplified, StripOptions::default());
//! for kind in ModelKind::ALL {
//!     let model = AnyModel::build(kind, &mut strips)?;
//!     let mut cursor = model.cursor();
//!     let lod = simplified.collapses().lod_for_triangles(100);
//!     model.seek(&mut cursor, lod, &mut ());
//!     assert!(model.triangles(&cursor).len() <= 100, "{}", kind.name());
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod any;
mod cpu;
mod cut;
pub mod interactive;
pub mod masking;
pub mod speed;
mod stored_strips;
pub mod trace;

pub use any::{AnyCursor, AnyModel, ModelKind};
pub use cut::{LONGEST_TRACED, cut_long};
pub use interactive::Interactive;
pub use masking::Masking;
pub use speed::Speed;
pub use stored_strips::check_submeshes;
