//! What the thesis measures, on any mesh: storage, the time and traffic of moves between levels,
//! primitives, progressive streams, and crowds that walk. Baselines are measured beside the models,
//! by cursors of the same form. It reads no file and prints nothing: results are structs to be
//! serialised, tables as text, charts as SVG.
//!
//! ```
//! use lodc_formats::{ObjectInfo, lodc::LodObject};
//! use lodc_lab::{Prepared, Settings, measure, tables};
//! use std::sync::Arc;
//!
//! let simplified = Arc::new(lodc_fixtures::random_collapse(&lodc_fixtures::icosphere(2), 1));
//! let info = ObjectInfo {
//!     name: "ball".to_owned(),
//!     submeshes: Vec::new(),
//!     world_scale: 1.0,
//!     document_mesh: 0,
//!     poses: vec![],
//! };
//! let object = LodObject { info, simplified, models: Vec::new() };
//! let prepared = Prepared::new(object, &[], Default::default())?;
//! let settings = Settings { steps: 0.1, rounds: None, streams: false };
//! let figures = measure(&prepared, &settings, None)?;
//! assert!(tables(&figures, settings.steps).contains("lodstrips"));
//! # Ok::<(), lodc_lab::LabError>(())
//! ```

mod baseline;
mod crowd;
#[cfg(feature = "gpu")]
mod device;
#[cfg(not(feature = "gpu"))]
#[path = "no_device.rs"]
mod device;
mod error;
mod object;
mod plots;
mod prepared;
mod primitives;
mod report;
mod stream;
mod strip_text;
mod structures;
mod sweep;
mod tables;
mod timings;

pub use baseline::{
    Baseline, BaselineCursor, Discrete, DiscreteCursor, LEVELS, LodStrips, LodStripsCursor,
    ProgressiveMesh, ProgressiveMeshCursor, Rebuild,
};
pub use crowd::{CrowdReport, CrowdSettings, crowd, crowd_charts, crowd_picture, crowd_table};
pub use device::{Device, most_triangles};
pub use error::LabError;
pub use object::measure;
pub use plots::charts;
pub use prepared::{Input, Prepared};
pub use primitives::{PrimitiveReport, strips as strip_primitives};
pub use report::{BenchObject, Settings};
pub use strip_text::StripText;
pub use structures::{baselines, plain};
pub use tables::tables;
