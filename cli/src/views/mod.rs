//! Levels of detail that depend on the view, as options ask for them.

mod options;

pub(crate) use options::{CriterionName, ViewArgs, point};

use crate::exit::Outcome;
use crate::selector::SelectorArgs;
use lodc::SceneLevels;
use lodc_scene::Arrangement;
use std::ops::Deref;

/// A scene as a criterion shows it.
pub(crate) struct SceneViews<'a>(lodc_select::SceneViews<'a>);

impl<'a> SceneViews<'a> {
    /// # Errors
    /// As [`lodc_select::SceneViews::new`].
    pub(crate) fn new(
        args: &ViewArgs,
        name: CriterionName,
        selector: &SelectorArgs,
        levels: &'a SceneLevels<'a>,
        scene: &Arrangement,
    ) -> Outcome<Self> {
        let options = args.options(name, selector);
        Ok(Self(lodc_select::SceneViews::new(options, levels, scene)?))
    }
}

impl<'a> Deref for SceneViews<'a> {
    type Target = lodc_select::SceneViews<'a>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}
