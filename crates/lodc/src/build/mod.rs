//! From a scene to objects with levels: simplify, measure errors, make models, check them.
//!
//! [`Builder`] does all of it. A host that shows progress or has options of its own for parts of a
//! scene calls the stages one after the other, as the program `lodc` does.

mod builder;
mod colours;
mod errors;
mod estimate;
mod gliding;
mod judge;
mod models;
mod object_pictures;
mod refitted;
mod scene_context;
mod simplify;
mod watch;

pub use builder::Builder;
pub use colours::{MetricColours, ObjectColours, SceneColours};
pub use errors::{
    DEFAULT_POSES, LevelDistance, choose_poses, measure_all, measure_levels, step_errors,
};
pub use estimate::{Need, Size};
pub use gliding::{GlideJudge, Way};
pub use models::{build_models, check_models, models};
pub use refitted::{Growth, measured, refitted_meshes};
pub use scene_context::{Importance, SceneContext};
pub use simplify::simplify_all;
pub use watch::Watch;

pub use lodc_errors::{Distances, Measurable, Tick, check as check_errors};

use lodc_formats::ObjectInfo;
use lodc_mesh::Simplified;
use std::sync::Arc;

/// Objects on their way from the simplifier to a file.
pub type SimplifiedObjects = Vec<(ObjectInfo, Arc<Simplified>)>;
