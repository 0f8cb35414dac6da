//! Many assets in one run: which they are, with which options, and how they are worked off.

mod assets;
mod folder;
mod manifest;
mod options;
mod pairs;
mod queue;
mod shard;
mod streams;

pub(crate) use assets::{Asset, Sources, assets};
pub(crate) use folder::globs;
pub(crate) use options::{
    OptionValues, arguments, given_options, has_option, is_command, is_of_the_run, know, suggestion,
};
pub(crate) use pairs::{Pair, pairs};
pub(crate) use queue::{Budget, run};
pub(crate) use shard::Shard;
pub(crate) use streams::check_streams;

use crate::exit::Outcome;
use crate::help::MANY;
use clap::Args;
use folder::Filter;
use std::path::PathBuf;

/// Extensions of the meshes that are taken from folders.
pub(crate) const MESHES: [&str; 3] = ["obj", "gltf", "glb"];

/// Extensions of the files with levels, stored or to be made, that are taken from folders.
pub(crate) const LEVELS: [&str; 4] = ["obj", "gltf", "glb", "lodc"];

/// Returns the files that were named and, in the place of each folder, its files with one of the
/// extensions.
///
/// # Errors
/// If a folder cannot be read or has no such file, or a glob is none.
pub(crate) fn expand(
    inputs: &[PathBuf],
    extensions: &[&str],
    include: &[String],
    exclude: &[String],
) -> Outcome<Vec<PathBuf>> {
    let filter = Filter::new(include, exclude)?;
    let mut all = Vec::new();
    for input in inputs {
        if input.is_dir() {
            let files = folder::files(input, extensions, &filter)?;
            all.extend(files.into_iter().map(|(path, _)| path));
        } else {
            all.push(input.clone());
        }
    }
    Ok(all)
}

/// Options of commands that take many assets.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = MANY)]
pub(crate) struct BatchArgs {
    /// List of assets, a JSON document in each line; - for standard input
    ///
    /// {"input": PATH, "output": PATH, "options": {"metric": "hybrid", ...}}; output and options may be
    /// left out. Of compare, {"a": PATH, "input": PATH, "options": ...}.
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub(crate) manifest: Option<PathBuf>,
    /// Of folders, only files whose path below the folder matches
    ///
    /// * does not match a slash, ** does. May be given several times.
    #[arg(long, value_name = "GLOB", hide_short_help = true)]
    pub(crate) include: Vec<String>,
    /// Of folders, no files whose path below the folder matches
    ///
    /// * does not match a slash, ** does. May be given several times.
    #[arg(long, value_name = "GLOB", hide_short_help = true)]
    pub(crate) exclude: Vec<String>,
    /// Do part I of N only, I from 1, for several machines
    ///
    /// The part of an asset depends on its path alone.
    #[arg(long, value_name = "I/N", value_parser = Shard::parse, hide_short_help = true)]
    pub(crate) shard: Option<Shard>,
}

impl BatchArgs {
    /// Returns whether a run has several results, or may have them.
    pub(crate) fn takes_many(&self, inputs: &[PathBuf]) -> bool {
        inputs.len() > 1 || self.manifest.is_some() || inputs.iter().any(|input| input.is_dir())
    }
}
