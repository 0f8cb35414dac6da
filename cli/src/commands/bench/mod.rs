//! `lodc bench`: storage, extraction time, bus traffic and primitives of every model and baseline
//! (thesis 3.5, 4.5, 5.5).

mod crowd;
mod gpu;
mod measure;
mod object;
mod plots;
mod primitives;
mod report;
mod stream;
mod subject;
mod text;
mod timings;

pub(crate) use primitives::strips as strips_of;
pub(crate) use subject::{baselines, plain};

use super::asset::{self, SimplifyArgs};
use super::build::MOST_THREADS;
use super::read::read_lodc;
use crate::console::{self, error, warning};
use crate::exit::{Failure, Outcome, Status};
use crate::gpu::{Device, GpuArgs};
use crate::help::{LIMITS, MEASURED, MORE, OUTPUT};
use crate::kinds::{MetricArgs, StripArgs, parser};
use crate::levels;
use crate::limits::ImportArgs;
use crate::output::{self, Target};
use crate::progress::Progress;
use crate::report::SCHEMA_VERSION;
use crate::stages::Stages;
use clap::Args;
use crowd::CrowdArgs;
use lodc_formats::lodc::LodObject;
use lodc_formats::{Document, ObjectInfo, import};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::Simplified;
use lodc_strip::{StripKind, StripOptions, StripPool, Strips};
use rayon::ThreadPoolBuilder;
use report::{BenchFile, BenchReport};
use std::num::{NonZeroU32, NonZeroUsize};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Options of `bench`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct BenchArgs {
    /// Meshes (.obj, .gltf, .glb), or .lodc files with their models as they are
    #[arg(value_name = "INPUT", required = true)]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    metric: MetricArgs,
    /// Models to measure, separated by commas [default: all]
    ///
    /// Those that a .lodc file has not are made.
    #[arg(long, value_delimiter = ',', value_name = "MODELS", value_parser = parser::<ModelKind>(),
          help_heading = MEASURED)]
    models: Vec<ModelKind>,
    /// Share of the LODs from one update to the next, in percent
    #[arg(long, value_name = "SHARE%", default_value = "0.1%", value_parser = share,
          help_heading = MEASURED, hide_short_help = true)]
    steps: f64,
    /// Rounds of timing, of which the best counts
    #[arg(long, value_name = "N", default_value = "5", help_heading = MEASURED)]
    rounds: NonZeroU32,
    /// Leave out everything that differs from run to run
    #[arg(long, help_heading = MEASURED)]
    no_times: bool,
    /// Also pack each object as a progressive stream
    ///
    /// Its size, its speed, and how far its prefixes are from the whole.
    #[arg(long, help_heading = MEASURED)]
    streams: bool,
    #[command(flatten)]
    crowd: CrowdArgs,
    #[command(flatten)]
    strips: StripArgs,
    #[command(flatten)]
    pub(crate) gpu: GpuArgs,
    /// Print one JSON document on standard output
    #[arg(long, help_heading = OUTPUT)]
    json: bool,
    /// Write the curves as SVG files into a folder
    #[arg(long, value_name = "DIR", help_heading = OUTPUT)]
    plots: Option<PathBuf>,
    #[command(flatten)]
    import: ImportArgs,
    /// Threads for making models; timing uses one [default: all cores]
    #[arg(long, value_name = "N", help_heading = LIMITS, hide_short_help = true)]
    jobs: Option<NonZeroUsize>,
}

const EXAMPLES: &str = "\
Everything is measured over the same collapse sequence, object by object, beside baselines that are \
never stored. Times are the best of several rounds in which everything takes turns; they differ from \
run to run. Everything else does not.

Examples:
  lodc bench chair.glb
  lodc bench chair.lodc --gpu --streams --json
  lodc bench figure.glb --crowd --plots charts --picture crowd.png";

fn share(text: &str) -> Result<f64, String> {
    match text.strip_suffix('%').unwrap_or(text).trim().parse::<f64>() {
        Ok(percent) if (1e-4..=100.0).contains(&percent) => Ok(percent / 100.0),
        _ => Err("not a percentage from 0.0001 to 100".to_owned()),
    }
}

impl BenchArgs {
    /// Returns whether a picture is wanted.
    pub(crate) fn draws(&self) -> bool {
        self.crowd.picture.is_some()
    }
}

pub(crate) fn run(args: &BenchArgs) -> Outcome<Status> {
    if args.inputs.iter().filter(|input| output::is_stream(input)).count() > 1 {
        return Err(Failure::usage("standard input can be read once only"));
    }
    let outputs = args.plots.iter().map(|folder| folder.join("-")).map(|file| (file, true));
    for (file, make_folder) in outputs.chain(args.crowd.picture.iter().map(|f| (f.clone(), false)))
    {
        output::prepare([&Target::File(file)], make_folder)?;
    }
    let device = gpu::open(&args.gpu)?;
    let threads = args.jobs.map_or(0, |n| n.get().min(MOST_THREADS));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool =
        pool.map_err(|e| Failure::new(Status::Limit, format!("no threads to work with: {e}")))?;
    let mut report = BenchReport {
        schema_version: SCHEMA_VERSION,
        tool_version: env!("CARGO_PKG_VERSION"),
        steps: args.steps,
        files: vec![],
        crowd: None,
    };
    if args.crowd.crowd {
        let device = match (&args.crowd.picture, device) {
            (Some(out), None) => Some(crate::gpu::open(None).map_err(|failure| {
                let message = format!("{}: {failure}; nothing was drawn", out.display());
                Failure { message, ..failure }
            })?),
            (_, device) => device,
        };
        return pool.install(|| crowd_of(args, device.as_ref(), report));
    }
    let mut worst = Status::Done;
    for input in &args.inputs {
        let (file, status) = pool.install(|| bench_one(args, device.as_ref(), input));
        worst = worst.max(status);
        if !args.json && file.error.is_none() {
            console::result(text::file(&file, args.steps).trim_end())?;
        }
        report.files.push(file);
    }
    if let Some(folder) = &args.plots {
        write_plots(folder, plots::plots(&report.files))?;
    }
    if args.json {
        console::json(&report)?;
    }
    Ok(worst)
}

/// A crowd of all inputs, and nothing else.
fn crowd_of(args: &BenchArgs, device: Option<&Device>, mut report: BenchReport) -> Outcome<Status> {
    let inputs: Vec<Input> =
        args.inputs.iter().map(|input| read(args, input)).collect::<Outcome<_>>()?;
    let crowd = crowd::measure(args, device, &inputs)?;
    if let Some(folder) = &args.plots {
        write_plots(folder, crowd::plots(&crowd))?;
    }
    if args.json {
        report.crowd = Some(crowd);
        console::json(&report)?;
    } else {
        console::result(crowd::text(&crowd).trim_end())?;
    }
    Ok(Status::Done)
}

/// One input. Whatever happens, there is a report, and the other inputs have their turn.
fn bench_one(args: &BenchArgs, device: Option<&Device>, input: &Path) -> (BenchFile, Status) {
    let name = input.display().to_string();
    let measured = catch_unwind(AssertUnwindSafe(|| {
        let objects = read(args, input)?.objects;
        objects.iter().map(|o| object::measure(args, device, o)).collect::<Outcome<Vec<_>>>()
    }));
    let failure = match measured {
        Ok(Ok(objects)) => return (BenchFile { file: name, error: None, objects }, Status::Done),
        Ok(Err(failure)) => {
            error(&failure);
            failure
        }
        // The panic hook has said what and where.
        Err(_) => Failure::new(Status::Bug, "internal error"),
    };
    (BenchFile { file: name, error: Some(failure.message), objects: vec![] }, failure.status)
}

/// An object with the models that were asked for, and strips of every kind.
struct Prepared {
    object: LodObject,
    strips: [Arc<Strips>; StripKind::ALL.len()],
}

impl Prepared {
    /// The strips of one kind.
    fn strips(&self, kind: StripKind) -> &Arc<Strips> {
        self.strips.iter().find(|strips| strips.kind == kind).expect("there are some of every kind")
    }
}

/// Makes what is missing of an object.
fn prepare(
    args: &BenchArgs,
    info: ObjectInfo,
    simplified: Arc<Simplified>,
    mut models: Vec<AnyModel>,
) -> Outcome<Prepared> {
    let options = args.strips.options();
    let mut pool = StripPool::new(&simplified, StripOptions { kind: None, ..options });
    // Not those of a file: its models may have cut them, or been made with another effort.
    pool.make(&StripKind::ALL, &|_| {});
    let strips = StripKind::ALL.map(|kind| pool.get(kind));
    let has = |models: &[AnyModel], kind: ModelKind| models.iter().any(|m| m.kind() == kind);
    let kinds = levels::chosen(&args.models);
    if !args.models.is_empty() {
        models.retain(|m| kinds.contains(&m.kind()));
    }
    let missing: Vec<ModelKind> = kinds.into_iter().filter(|&kind| !has(&models, kind)).collect();
    if options.kind.is_some() {
        pool = StripPool::new(&simplified, options);
    }
    let bug = |what: String| Failure::new(Status::Bug, format!("{}: {what}", info.name));
    models.extend(levels::models(&mut pool, &missing, &|_| {}).map_err(bug)?);
    models.sort_by_key(AnyModel::kind);
    Ok(Prepared { object: LodObject { info, simplified, models }, strips })
}

/// An input with everything that is measured.
struct Input {
    objects: Vec<Prepared>,
    #[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "only what is drawn is posed"))]
    document: Document,
}

/// Writes charts into a folder.
///
/// # Errors
/// If that cannot be done.
fn write_plots<N: AsRef<Path>>(folder: &Path, plots: Vec<(N, String)>) -> Outcome<()> {
    let (targets, texts): (Vec<Target>, Vec<String>) =
        plots.into_iter().map(|(name, svg)| (Target::File(folder.join(name)), svg)).unzip();
    output::prepare(&targets, true)?;
    targets.iter().zip(texts).try_for_each(|(to, svg)| output::write(to, svg.into_bytes()))
}

/// Reads an input and makes what is measured.
fn read(args: &BenchArgs, input: &Path) -> Outcome<Input> {
    if input.extension().is_some_and(|e| e.eq_ignore_ascii_case("lodc")) {
        let (file, _) = read_lodc(input, args.import.options().limits)?;
        let objects = file.objects.into_iter();
        let objects = objects.map(|o| prepare(args, o.info, o.simplified, o.models));
        return Ok(Input { objects: objects.collect::<Outcome<_>>()?, document: file.document });
    }
    let scene = import::import(input, &args.import.options())?;
    let how = SimplifyArgs::by(args.metric.metric);
    let asset = asset::simplified(input, &args.import, &how, scene, &mut Stages::default())?;
    let name = input.display().to_string();
    asset.warnings.iter().for_each(|what| warning(&name, what));
    let progress = Progress::new(&name);
    progress.stage("models");
    let objects = asset.objects.into_iter();
    let objects = objects.map(|o| prepare(args, o.info, o.simplified, o.models));
    Ok(Input { objects: objects.collect::<Outcome<_>>()?, document: asset.document })
}
