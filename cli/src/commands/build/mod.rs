//! `lodc build`: OBJ, glTF and GLB to `.lodc`.

mod counts;
mod known;
mod pipeline;
mod summary;
mod work;

pub(crate) use counts::counts;
pub(crate) use known::importance;
pub(crate) use pipeline::object_options;

use crate::batch::{self, BatchArgs, MESHES, Sources};
use crate::commands::each;
use crate::config::ConfigArgs;
use crate::exit::{Outcome, Status};
use crate::importance::ImportanceArgs;
use crate::kinds::{MetricArgs, ModelArgs, StripArgs};
use crate::limits::ImportArgs;
use crate::parts::PartArgs;
use crate::program::Program;
use crate::threads;
use clap::{Args, ValueEnum};
use lodc_simplify::Options;
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// Options of `build`.
#[derive(Args, Clone, Debug)]
pub(crate) struct BuildArgs {
    /// Meshes to read: OBJ, glTF or GLB, or folders of them; `-` for standard input
    #[arg(required_unless_present = "manifest")]
    inputs: Vec<PathBuf>,
    /// A file for one input, a folder for several; `-` for standard output [default: beside the
    /// input, as .lodc]. Results of a folder keep its structure and their extensions
    /// (club.obj.lodc)
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    #[command(flatten)]
    models: ModelArgs,
    #[command(flatten)]
    metric: MetricArgs,
    /// No change of topology before the terminal phase
    #[arg(long)]
    preserve_topology: bool,
    /// Border vertices stay until the terminal phase
    #[arg(long)]
    lock_border: bool,
    /// Normals, texture coordinates and colours take no part in the cost
    #[arg(long)]
    no_attributes: bool,
    #[command(flatten)]
    importance: ImportanceArgs,
    #[command(flatten)]
    parts: PartArgs,
    #[command(flatten)]
    strips: StripArgs,
    /// Threads; the output does not depend on it [default: all cores]
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    /// Leave results alone whose input, the files it names, options and version are as they were
    #[arg(long)]
    if_changed: bool,
    /// Print a report on standard output: one document, or one in each line as results come
    #[arg(long, value_enum, value_name = "FORMAT")]
    report: Option<ReportFormat>,
    /// Write a Make/Ninja dependency file that names every file read
    #[arg(long, value_name = "FILE")]
    depfile: Option<PathBuf>,
    #[command(flatten)]
    import: ImportArgs,
    #[command(flatten)]
    batch: BatchArgs,
    #[command(flatten)]
    configuration: ConfigArgs,
    /// Every option that can change the result, as text.
    #[arg(skip)]
    resolved: String,
}

/// Formats of the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ReportFormat {
    Json,
    Jsonl,
}

impl BuildArgs {
    /// Returns whether there is one input, in a small file.
    pub(crate) fn is_small(&self) -> bool {
        !self.batch.takes_many(&self.inputs) && self.inputs.iter().all(|i| each::is_small(i))
    }

    /// Options of simplifying an asset.
    fn simplify_options(&self) -> Options {
        Options {
            metric: self.metric.metric,
            preserve_topology: self.preserve_topology,
            lock_border: self.lock_border,
            attributes: !self.no_attributes,
            weights: self.importance.weights(),
            ..Options::DEFAULT
        }
    }
}

pub(crate) fn run(args: &BuildArgs, program: &Program) -> Outcome<Status> {
    args.models.kinds()?;
    let sources = Sources {
        inputs: &args.inputs,
        output: args.output.as_deref(),
        reads: &MESHES,
        writes: "lodc",
    };
    let mut assets = batch::assets(sources, &args.batch)?;
    args.configuration.apply(program, "build", &mut assets)?;
    batch::check_streams(&assets, args.report.is_some(), args.depfile.as_deref())?;
    let pool = threads::pool(args.jobs)?;
    work::all(args, program, &assets, &pool)
}
