//! Many assets in one run, in one room: which they are (files, folders, lists, parts of a batch for
//! many machines), what each is given (its own options, those of `lodc.toml`, those of its parts),
//! where its result goes, and in which order they are worked off within the memory there is. It
//! knows no command line: [`Vocabulary`] says which options there are.
//!
//! ```
//! use lodc_assets::{Choice, Sources, assets};
//! use std::path::{Path, PathBuf};
//!
//! let inputs = ["chair.obj", "props/lamp.glb"].map(PathBuf::from);
//! let output = Some(Path::new("built"));
//! let reads = &["obj", "glb"];
//! let sources = Sources { inputs: &inputs, output, reads, writes: "lodc", allowed: &[] };
//! let all = assets(sources, &Choice::default())?;
//! let target = all[1].target.as_ref().map(|target| target.name().replace('\\', "/"));
//! assert_eq!(target, Ok("built/lamp.lodc".to_owned()));
//! # Ok::<(), lodc_assets::AssetError>(())
//! ```

mod assets;
mod baseline;
mod config;
mod error;
mod folder;
mod manifest;
mod options;
mod pairs;
mod parts;
mod queue;
mod shard;
mod streams;
mod target;

pub use assets::{Asset, Choice, Sources, assets};
pub use baseline::Baseline;
pub use config::{Configs, Layer};
pub use error::AssetError;
pub use folder::{LEVELS, MESHES, expand};
pub use options::{CommandOptions, LIMIT, OptionValues, Vocabulary};
pub use pairs::{Pair, pairs};
pub use parts::{Part, Parts, listed};
pub use queue::{Budget, expected_bytes, run};
pub use shard::Shard;
pub use streams::check_streams;
pub use target::{Rule, Target, is_folder, is_stream, prepare, target};
