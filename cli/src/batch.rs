//! Options that choose the assets of a run: a list (one JSON document in each line), globs for
//! folders, and shards for several machines.

use crate::exit::Outcome;
use crate::help::MANY_ASSETS;
use crate::jobs::{JobChoice, Shard};
use clap::Args;
use std::path::{Path, PathBuf};

pub(crate) use crate::jobs::{
    Budget, CommandPaths, Job, LEVEL_EXTENSIONS, MESH_EXTENSIONS, OptionValues, Pair, RECORDS,
    check_standard_streams, expand_folders, has_extension, orphans,
};

/// Options of commands that take many assets.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = MANY_ASSETS)]
pub(crate) struct BatchArgs {
    /// List of assets, a JSON document in each line; - for standard input
    ///
    /// {"input": PATH, "output": PATH, "options": {"metric": "hybrid", ...}}; output and options
    /// may be left out. Of compare, {"a": PATH, "input": PATH, "options": ...}.
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub(crate) manifest: Option<PathBuf>,
    /// In folders, only files whose path below the folder matches
    ///
    /// * does not match a slash, ** does. May be given several times.
    #[arg(long, value_name = "GLOB", hide_short_help = true)]
    pub(crate) include: Vec<String>,
    /// In folders, no files whose path below the folder matches
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
    /// The choice of assets that the options make.
    fn choice(&self) -> JobChoice {
        let Self { manifest, include, exclude, shard } = self.clone();
        JobChoice { list: manifest, include, exclude, shard }
    }

    /// Returns whether a run has several results, or may have them.
    pub(crate) fn takes_many(&self, inputs: &[PathBuf]) -> bool {
        self.choice().takes_many(inputs)
    }
}

/// The assets of a run, in order.
///
/// # Errors
/// As [`crate::jobs::jobs`].
pub(crate) fn jobs(paths: CommandPaths<'_>, batch: &BatchArgs) -> Outcome<Vec<Job>> {
    Ok(crate::jobs::jobs(paths, &batch.choice())?)
}

/// The pairs of files that a run compares.
///
/// # Errors
/// As [`crate::jobs::pairs`].
pub(crate) fn pairs(named: Option<[&Path; 2]>, batch: &BatchArgs) -> Outcome<Vec<Pair>> {
    Ok(crate::jobs::pairs(named, &batch.choice())?)
}
