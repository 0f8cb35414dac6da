//! The stages from a scene to objects with levels: simplify, measure errors, make models, check
//! them. [`Asset`](crate::Asset) runs them.

mod colours;
mod errors;
mod estimate;
mod geomorph;
mod metric_selection;
mod models;
mod object_pictures;
mod painted;
mod refitted;
mod scene_context;
mod simplify;
mod watch;

pub(crate) use colours::MetricColours;
pub use colours::{ObjectColours, SceneColours, read_colours};
pub use errors::{DEFAULT_POSES, LevelDistance, step_errors};
pub(crate) use errors::{choose_poses, measure_all, measure_levels};
pub use estimate::{Need, Size};
pub use geomorph::{GeomorphJudge, Way};
pub(crate) use models::check_models;
pub use models::{build_models, models};
pub use painted::{Painted, PaintedValues};
pub use refitted::{Growth, measured, refitted_meshes};
pub use scene_context::Importance;
pub(crate) use scene_context::SceneContext;
pub(crate) use simplify::simplify_all;
pub use watch::Watch;

pub use lodc_errors::{Distances, Measurable, Tick, check as check_errors};

use lodc_formats::ObjectInfo;
use lodc_mesh::Simplified;
use std::sync::Arc;

/// Objects on their way from the simplifier to a file.
type SimplifiedObjects = Vec<(ObjectInfo, Arc<Simplified>)>;
