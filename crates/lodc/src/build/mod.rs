//! From a scene to objects with levels: simplify, measure errors, make models, check them.

mod errors;
mod estimate;
mod judge;
mod known;
mod models;
mod paints;
mod refitted;
mod simplify;
mod watch;

pub use errors::measure_all;
pub use estimate::{Need, Size};
pub use known::{Importance, Known};
pub use models::{build_models, check_models, models};
pub use paints::{ObjectColours, Paints};
pub use refitted::refitted_meshes;
pub use simplify::simplify_all;
pub use watch::Watch;

use lodc_formats::ObjectInfo;
use lodc_mesh::Simplified;
use std::sync::Arc;

/// Objects on their way from the simplifier to a file.
pub type SimplifiedObjects = Vec<(ObjectInfo, Arc<Simplified>)>;
