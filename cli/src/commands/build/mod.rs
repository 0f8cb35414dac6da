//! `lodc build`: OBJ, glTF and GLB to `.lodc`.

mod counts;
mod errors;
mod pipeline;
mod summary;

pub(crate) use counts::counts;
pub(crate) use errors::measure_all;
pub(crate) use pipeline::simplify_all;

use crate::console::{self, error};
use crate::exit::{Failure, Outcome, Status};
use crate::kinds::{MetricArgs, StripArgs, parser};
use crate::limits::ImportArgs;
use crate::output::{self, Rule, Target};
use crate::progress::Progress;
use crate::report::{BuildReport, InputReport, SCHEMA_VERSION};
use crate::stages::Stages;
use clap::{Args, ValueEnum};
use lodc_lod::ModelKind;
use rayon::ThreadPoolBuilder;
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// More threads than this help nobody; asking for more is no mistake.
pub(crate) const MOST_THREADS: usize = 256;

/// Options of `build`.
#[derive(Args, Debug)]
pub(crate) struct BuildArgs {
    /// Meshes to read: OBJ, glTF or GLB; `-` for standard input
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// A file for one input, a folder for several; `-` for standard output [default: beside the
    /// input, as .lodc]
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// Structures to write, separated by commas [default: every one that this version has]
    #[arg(long, value_delimiter = ',', value_name = "MODELS", value_parser = parser::<ModelKind>())]
    models: Vec<ModelKind>,
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
    strips: StripArgs,
    /// Threads; the output does not depend on it [default: all cores]
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    /// Print a report on standard output
    #[arg(long, value_enum, value_name = "FORMAT")]
    report: Option<ReportFormat>,
    /// Write a Make/Ninja dependency file that names every file read
    #[arg(long, value_name = "FILE")]
    depfile: Option<PathBuf>,
    #[command(flatten)]
    import: ImportArgs,
}

/// Formats of the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ReportFormat {
    Json,
}

pub(crate) fn run(args: &BuildArgs) -> Outcome<Status> {
    let targets = output::targets(&args.inputs, args.output.as_deref(), "lodc")?;
    check_streams(args, &targets)?;
    let folder = args.inputs.len() > 1 || args.output.as_deref().is_some_and(output::is_folder);
    output::prepare(&targets, folder)?;
    let threads = args.jobs.map_or(0, |n| n.get().min(MOST_THREADS));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool =
        pool.map_err(|e| Failure::new(Status::Limit, format!("no threads to work with: {e}")))?;

    let mut report = BuildReport {
        schema_version: SCHEMA_VERSION,
        tool_version: env!("CARGO_PKG_VERSION"),
        inputs: vec![],
    };
    let mut rules = Vec::new();
    let mut worst = Status::Done;
    for (input, target) in args.inputs.iter().zip(&targets) {
        let (one, rule, status) = pool.install(|| build_one(args, input, target));
        worst = worst.max(status);
        report.inputs.push(one);
        rules.extend(rule);
    }
    if let Some(depfile) = &args.depfile
        && let Err(failure) = output::write_depfile(depfile, &rules)
    {
        error(&failure);
        worst = worst.max(failure.status);
    }
    if args.report == Some(ReportFormat::Json) {
        console::json(&report)?;
    }
    Ok(worst)
}

/// One input from bytes to bytes. Whatever happens, there is a report, and the other inputs have
/// their turn.
fn build_one(
    args: &BuildArgs,
    input: &Path,
    target: &Target,
) -> (InputReport, Option<Rule>, Status) {
    let mut report = InputReport {
        input: input.display().to_string(),
        output: target.name(),
        ..InputReport::default()
    };
    let mut stages = Stages::default();
    let progress = Progress::new(&report.input);
    crate::memory::reset_peak();
    let made = catch_unwind(AssertUnwindSafe(|| {
        pipeline::make(args, input, target, &mut stages, &progress, &mut report)
    }));
    drop(progress);
    report.peak_bytes = crate::memory::peak_bytes();
    for warning in &report.warnings {
        console::warning(&report.input, warning);
    }
    let (status, rule) = match made {
        Ok(Ok(made)) => {
            summary::print(&made, target, stages.seconds());
            let rule = match target {
                Target::File(path) => Some(Rule { output: path.clone(), inputs: made.files_read }),
                Target::Stdout => None,
            };
            (Status::Done, rule)
        }
        Ok(Err(failure)) => {
            // An error in a file that the input refers to names that file; with several inputs both
            // are needed.
            let named = failure.status != Status::Input || failure.message.contains(&report.input);
            let named = named || output::is_stream(input);
            let failure = if named {
                failure
            } else {
                Failure::new(failure.status, format!("{}: {}", report.input, failure.message))
            };
            error(&failure);
            report.error = Some(failure.message);
            (failure.status, None)
        }
        Err(_) => {
            // The panic hook has said what and where.
            report.error = Some("internal error".to_owned());
            (Status::Bug, None)
        }
    };
    report.status = status.code();
    report.stages = stages.into_reports();
    (report, rule, status)
}

/// One stream holds one thing.
fn check_streams(args: &BuildArgs, targets: &[Target]) -> Outcome<()> {
    if args.inputs.iter().filter(|input| output::is_stream(input)).count() > 1 {
        return Err(Failure::usage("standard input can be read once only"));
    }
    let to_stdout = targets.contains(&Target::Stdout);
    if to_stdout && args.report.is_some() {
        return Err(Failure::usage("the report and the output do not fit one standard output"));
    }
    let Some(depfile) = &args.depfile else { return Ok(()) };
    if to_stdout || output::is_stream(depfile) {
        return Err(Failure::usage("a dependency file needs files, not standard output"));
    }
    let others =
        targets.iter().map(Target::name).chain(args.inputs.iter().map(|i| i.display().to_string()));
    if others.into_iter().any(|other| other == depfile.display().to_string()) {
        return Err(Failure::usage(format!(
            "{}: named both as dependency file and as mesh",
            depfile.display()
        )));
    }
    output::prepare(&[Target::File(depfile.clone())], false)
}
