//! The option that gives options to parts of an asset: objects and materials.

use crate::help::SIMPLIFIED;
use crate::importance;
use crate::jobs::{Part, Parts};
use clap::Args;

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
    /// The parts.
    pub(crate) fn all(&self) -> Parts<'_> {
        Parts(&self.parts)
    }
}
