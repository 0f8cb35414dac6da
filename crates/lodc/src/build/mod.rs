//! From a scene to objects with levels: simplify, measure errors, make models, check them.
//!
//! [`Builder`] does all of it. A host that shows progress or has options of its own for parts of a
//! scene calls the stages one after the other, as the program `lodc` does.

mod builder;
mod errors;
mod estimate;
mod judge;
mod models;
mod object_pictures;
mod paints;
mod refitted;
mod scene_context;
mod simplify;
mod watch;

pub use builder::Builder;
pub use errors::{LevelDistance, POSES, choose_poses, measure_all, measure_levels};
pub use estimate::{Need, Size};
pub use models::{build_models, check_models, models};
pub use paints::{ObjectColours, Paints, ScenePaints};
pub use refitted::{measured, refitted_meshes};
pub use scene_context::{Importance, SceneContext};
pub use simplify::simplify_all;
pub use watch::Watch;

pub use lodc_errors::{Tick, measure_over as step_errors};

use lodc_formats::ObjectInfo;
use lodc_mesh::Simplified;
use std::sync::Arc;

/// Objects on their way from the simplifier to a file.
pub type SimplifiedObjects = Vec<(ObjectInfo, Arc<Simplified>)>;
