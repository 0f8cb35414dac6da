//! Many assets in one run: which files they are (named ones, files of folders, lines of a list, one
//! shard of all of them), which options each has (its own, those of `lodc.toml`, those of its
//! parts), where its result goes, and in which order the assets are worked on within the memory
//! that is available. It knows no command line: [`Vocabulary`] says which options there are.
//!
//! ```
//! use lodc_assets::{CommandPaths, JobChoice, jobs};
//! use std::path::{Path, PathBuf};
//!
//! let inputs = ["chair.obj", "props/lamp.glb"].map(PathBuf::from);
//! let paths = CommandPaths {
//!     inputs: &inputs,
//!     output: Some(Path::new("built")),
//!     input_extensions: &["obj", "glb"],
//!     output_extension: "lodc",
//!     allowed_folders: &[],
//! };
//! let all = jobs(paths, &JobChoice::default())?;
//! let target = all[1].target.as_ref().map(|target| target.name().replace('\\', "/"));
//! assert_eq!(target, Ok("built/lamp.glb.lodc".to_owned()));
//! # Ok::<(), lodc_assets::JobError>(())
//! ```

mod baseline;
mod config;
mod depfile;
mod error;
mod folder;
mod jobs;
mod list;
mod options;
mod orphans;
mod pairs;
mod parts;
mod queue;
mod shard;
mod standard_streams;
mod target;

pub use baseline::Baseline;
pub use config::{ConfigLayer, Configs};
pub use depfile::DependencyRule;
pub use error::JobError;
pub use folder::{LEVEL_EXTENSIONS, MESH_EXTENSIONS, expand_folders, has_extension};
pub use jobs::{CommandPaths, Job, JobChoice, jobs};
pub use options::{CommandOptions, LIMIT_OPTION, OptionValues, ValueCheck, Vocabulary};
pub use orphans::{RECORDS, orphans};
pub use pairs::{Pair, pairs};
pub use parts::{Part, Parts, name_list};
pub use queue::{Budget, expected_bytes, run_queue};
pub use shard::Shard;
pub use standard_streams::check_standard_streams;
pub use target::{Target, is_folder, is_standard_stream, prepare_targets, single_target};
