//! Options of commands that take many assets.

use crate::exit::Outcome;
use clap::Args;
use lodc_assets::{Choice, Shard};
use std::path::{Path, PathBuf};

pub(crate) use lodc_assets::{
    Asset, Budget, LEVELS, MESHES, OptionValues, Pair, Sources, check_streams, expand, run,
};

/// Options of commands that take many assets.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Many assets")]
pub(crate) struct BatchArgs {
    /// Read assets from FILE, a JSON document in each line: {"input": PATH, "output": PATH,
    /// "options": {"metric": "hybrid", ...}}; the last two may be left out; of `compare`, {"a":
    /// PATH, "input": PATH, "options": ...}; `-` for standard input
    #[arg(long, value_name = "FILE")]
    pub(crate) manifest: Option<PathBuf>,
    /// Of folders, take only files whose path below the folder matches (may be given several
    /// times)
    #[arg(long, value_name = "GLOB")]
    pub(crate) include: Vec<String>,
    /// Of folders, leave out files whose path below the folder matches (may be given several
    /// times)
    #[arg(long, value_name = "GLOB")]
    pub(crate) exclude: Vec<String>,
    /// Do part I of N only, I from 1; which part an asset is in depends on its path alone
    #[arg(long, value_name = "I/N", value_parser = Shard::parse)]
    pub(crate) shard: Option<Shard>,
}

impl BatchArgs {
    /// The choice of assets.
    fn choice(&self) -> Choice {
        let Self { manifest, include, exclude, shard } = self.clone();
        Choice { list: manifest, include, exclude, shard }
    }

    /// Returns whether a run has several results, or may have them.
    pub(crate) fn takes_many(&self, inputs: &[PathBuf]) -> bool {
        self.choice().takes_many(inputs)
    }
}

/// The assets of a run.
///
/// # Errors
/// As [`lodc_assets::assets`].
pub(crate) fn assets(sources: Sources<'_>, batch: &BatchArgs) -> Outcome<Vec<Asset>> {
    Ok(lodc_assets::assets(sources, &batch.choice())?)
}

/// The pairs of a run.
///
/// # Errors
/// As [`lodc_assets::pairs`].
pub(crate) fn pairs(named: Option<[&Path; 2]>, batch: &BatchArgs) -> Outcome<Vec<Pair>> {
    Ok(lodc_assets::pairs(named, &batch.choice())?)
}
