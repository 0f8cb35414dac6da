//! Many assets in one run: which files they are (named ones, files of folders, lines of a list, one
//! shard of all of them), which options each has (its own, those of `lodc.toml`, those of its
//! parts), where its result goes, and in which order the assets are worked on within the memory
//! that is available. It knows no command line: [`Vocabulary`] says which options there are.

mod baseline;
mod config;
mod depfile;
mod error;
mod folder;
mod list;
mod options;
mod orphans;
mod pairs;
mod parts;
mod queue;
mod run;
mod shard;
mod standard_streams;
mod target;

pub(crate) use baseline::Baseline;
pub(crate) use config::{ConfigLayer, Configs};
pub(crate) use depfile::DependencyRule;
pub(crate) use error::JobError;
pub(crate) use folder::{LEVEL_EXTENSIONS, MESH_EXTENSIONS, expand_folders, has_extension};
pub(crate) use list::json_object;
pub(crate) use options::{CommandOptions, LIMIT_OPTION, OptionValues, ValueCheck, Vocabulary};
pub(crate) use orphans::{RECORDS, orphans};
pub(crate) use pairs::{Pair, pairs};
pub(crate) use parts::{Part, Parts, name_list};
pub(crate) use queue::{Budget, Queue, expected_bytes, locked};
pub(crate) use run::{CommandPaths, Job, JobChoice, jobs};
pub(crate) use shard::Shard;
pub(crate) use standard_streams::check_standard_streams;
pub(crate) use target::{
    Target, is_folder, is_standard_stream, of_kind, path_identity, prepare_targets, single_target,
};
