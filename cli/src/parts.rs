//! Options of parts of an asset: of objects and of materials, by their names.

use crate::exit::Outcome;
use crate::help::SIMPLIFIED;
use crate::importance;
use clap::Args;
use lodc_assets::{Part, Parts};
use lodc_formats::Scene;
use lodc_select::Target;
use lodc_simplify::{Options, Weights};

/// Options of parts.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct PartArgs {
    /// Options of objects or materials by name, as JSON
    ///
    /// {"objects": [GLOB, ...], "metric": "hybrid", "weight": "uv=2", "lock": true}, or
    /// {"materials": [GLOB, ...], "weight": "uv=2", "lock": true}. May be given several times;
    /// later ones win. People write this in lodc.toml.
    #[arg(long = "part", value_name = "JSON", value_parser = part,
          help_heading = SIMPLIFIED, hide_short_help = true)]
    parts: Vec<Part>,
}

/// Reads the options of a part.
///
/// # Errors
/// As [`Part::parse`].
pub(crate) fn part(text: &str) -> Result<Part, String> {
    Part::parse(text, importance::weights)
}

impl PartArgs {
    fn all(&self) -> Parts<'_> {
        Parts(&self.parts)
    }

    /// See [`Parts::options`].
    pub(crate) fn options(&self, object: &str, options: Options) -> Options {
        self.all().options(object, options)
    }

    /// See [`Parts::weights`].
    pub(crate) fn weights(&self, scene: &Scene, options: &[Options]) -> Outcome<Vec<Vec<Weights>>> {
        Ok(self.all().weights(scene, options)?)
    }

    /// See [`Parts::check`].
    pub(crate) fn check(&self, scene: &Scene) -> Outcome<()> {
        Ok(self.all().check(scene)?)
    }

    /// See [`Parts::lock`].
    pub(crate) fn lock(&self, scene: &Scene, locked: &mut [Vec<bool>]) -> Outcome<()> {
        Ok(self.all().lock(scene, locked)?)
    }

    /// See [`Parts::ratio`].
    pub(crate) fn ratio(&self, object: &str) -> Option<Target> {
        self.all().ratio(object)
    }

    /// See [`Parts::level`].
    pub(crate) fn level(&self, object: &str, place: usize) -> Option<Target> {
        self.all().level(object, place)
    }

    /// See [`Parts::refuse`].
    pub(crate) fn refuse(&self, input: &str) -> Outcome<()> {
        Ok(self.all().refuse(input)?)
    }
}
