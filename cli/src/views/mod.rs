//! Levels of detail that depend on the view: what options ask for, and what is shown.

mod options;
mod scene;

pub(crate) use options::{CriterionName, ViewArgs, point};
pub(crate) use scene::SceneViews;
