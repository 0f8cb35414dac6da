//! `lodc build`: turns meshes into `.lodc` files.

mod counts;
mod estimate;
mod importance;
mod pipeline;
mod summary;
mod work;

pub(crate) use counts::counts;
pub(crate) use importance::importance;
pub(crate) use pipeline::object_options;
pub(crate) use work::run;

use crate::batch::BatchArgs;
use crate::commands::estimate::is_small;
use crate::commands::prune::PruneArgs;
use crate::commands::runs::RunArgs;
use crate::config::ConfigArgs;
use crate::help::{MORE, OUTPUT, SIMPLIFIED, STORED};
use crate::importance::ImportanceArgs;
use crate::kinds::{MetricArgs, ModelArgs, PosesArgs, StepOrderArgs, StripArgs};
use crate::limits::ImportArgs;
use crate::parts::PartArgs;
use clap::Args;
use lodc_simplify::Options;
use std::path::PathBuf;

/// Options of `build`.
#[derive(Args, Clone, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct BuildArgs {
    /// Meshes (.glb, .gltf, .obj, .ply, .stl), or folders of them; - for standard input
    #[arg(value_name = "INPUT", required_unless_present = "manifest")]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    metric: MetricArgs,
    /// Keep the topology until the terminal phase
    ///
    /// In that phase components shrink to points and points are joined, until one vertex is left.
    #[arg(long, help_heading = SIMPLIFIED, hide_short_help = true)]
    preserve_topology: bool,
    /// Look at the shape alone: no normals, texture coordinates or colours
    ///
    /// They do not affect the cost, but are kept.
    #[arg(long, help_heading = SIMPLIFIED)]
    no_attributes: bool,
    #[command(flatten)]
    importance: ImportanceArgs,
    #[command(flatten)]
    parts: PartArgs,
    #[command(flatten)]
    poses: PosesArgs,
    #[command(flatten)]
    sequence: StepOrderArgs,
    /// The structures that a file holds besides the collapse sequence.
    #[command(flatten)]
    models: ModelArgs,
    #[command(flatten)]
    strips: StripArgs,
    /// Put the images that a .gltf names into the file
    ///
    /// Without it they stay files, to be copied beside it. Images that a GLB holds are inside in
    /// any case; the materials of an OBJ or PLY name files.
    #[arg(long, help_heading = STORED, hide_short_help = true)]
    embed: bool,
    /// File, or folder for several inputs; - for standard output [default: beside the input]
    ///
    /// A folder that is there, or a name with / at its end, means a file inside it. There, and
    /// beside the input, club.obj becomes club.obj.lodc; results of a folder keep its structure.
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT)]
    output: Option<PathBuf>,
    /// Say how much memory each build needs, and build nothing
    ///
    /// Estimated from file headers, for text from its lines. With --report, as JSON.
    #[arg(long, help_heading = OUTPUT, hide_short_help = true)]
    estimate: bool,
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    prune: PruneArgs,
    #[command(flatten)]
    batch: BatchArgs,
    #[command(flatten)]
    configuration: ConfigArgs,
    #[command(flatten)]
    import: ImportArgs,
    /// Every option that can change the result, as text.
    #[arg(skip)]
    options_text: String,
}

const EXAMPLES: &str = "\
Examples:
  lodc build chair.glb -o chair.lodc
  lodc build chairs -o levels --if-changed --exclude 'drafts/**'
  lodc build hero.glb --metric hybrid --lock material:face --models none";

impl BuildArgs {
    /// Returns whether there is one input, in a small file.
    pub(crate) fn is_small(&self) -> bool {
        !self.batch.takes_many(&self.inputs) && self.inputs.iter().all(|i| is_small(i))
    }

    /// Options of simplifying an asset.
    fn simplify_options(&self) -> Options {
        Options {
            metric: self.metric.metric,
            preserve_topology: self.preserve_topology,
            lock_border: self.importance.lock_border,
            attributes: !self.no_attributes,
            weights: self.importance.weights(),
            ..Options::DEFAULT
        }
    }
}
