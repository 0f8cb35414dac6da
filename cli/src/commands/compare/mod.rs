//! `lodc compare`: how far apart two meshes, or those of two folders, are, in space and in
//! pictures; with limits or the numbers of an earlier run, a check for pipelines.

mod baseline;
mod measure;
mod surface;

use super::asset::SimplifyArgs;
use super::ci::CiArgs;
use super::each::{self, JobOptions};
use crate::batch::{self, BatchArgs, Job, Pair};
use crate::clock;
use crate::config::ConfigArgs;
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::help::{DIFFERENCE, LEVEL, MEASURED, MORE, OUTPUT};
use crate::jobs::JobError;
use crate::limits::ImportArgs;
use crate::numbers::whole;
use crate::output::{self, Target as Output};
use crate::pose::PoseArgs;
use crate::program::Program;
use crate::progress::BatchProgress;
use crate::results::{self, FailureReport, ResultReport, print_failure};
use crate::selector::{SelectorArgs, size};
use baseline::Baseline;
use clap::Args;
use lodc_report::{Case, ComparisonLimits, Length, PairReport, Suite, Verdict};
use lodc_select::Target;
use measure::Measured;
use std::path::{Path, PathBuf};
use surface::LevelChoice;

/// Distances below this share of the diagonal are rounding errors: the heatmap does not show them.
/// Chosen by hand.
const ROUNDING_SHARE: f64 = 1e-6;

/// Options of `compare`.
#[derive(Args, Clone, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct CompareArgs {
    /// Mesh to compare with (.glb, .gltf, .obj, .ply, .stl, .lodc), or folder; - for standard input
    #[arg(required_unless_present = "manifest", conflicts_with = "manifest", requires = "b")]
    a: Option<PathBuf>,
    /// Mesh to judge, or whose levels to judge; or folder
    ///
    /// Levels of a mesh are made in memory. Of folders, each file of B is compared with that of A
    /// of the same path, with or without a further extension.
    #[arg(required_unless_present = "manifest")]
    b: Option<PathBuf>,
    #[command(flatten)]
    level_b: SelectorArgs,
    /// Levels of B, each by itself: shares (25%) or counts (10k)
    ///
    /// Of triangles.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = level,
          conflicts_with = "TargetArgs", help_heading = LEVEL)]
    levels: Vec<ComparedLevel>,
    /// Level of A: a share (25%) or a count (10k) of triangles [default: all]
    #[arg(long, value_name = "LEVEL", value_parser = size, help_heading = LEVEL,
          hide_short_help = true)]
    level_a: Option<Target>,
    #[command(flatten)]
    pose: PoseArgs,
    #[command(flatten)]
    simplify: SimplifyArgs,
    /// Points spread over the area of each mesh, up to 100 million
    #[arg(long, value_name = "N", default_value = "200000",
          value_parser = whole::<u32>(1..=100_000_000),
          help_heading = MEASURED, hide_short_help = true)]
    samples: u32,
    /// Seed of the points: the same number gives the same points
    #[arg(long, value_name = "N", default_value = "1", value_parser = whole::<u64>(0..),
          help_heading = MEASURED, hide_short_help = true)]
    seed: u64,
    /// Pictures, from all sides, up to 1000; 0 for none
    #[arg(long, value_name = "N", default_value = "24",
          value_parser = whole::<u32>(0..=1000), help_heading = MEASURED,
          hide_short_help = true)]
    views: u32,
    /// Pixels across each picture, 16 to 2048
    #[arg(long, value_name = "N", default_value = "512",
          value_parser = whole::<u32>(16..=2048), help_heading = MEASURED,
          hide_short_help = true)]
    size: u32,
    /// Look at the shape alone: no normals, textures or texture coordinates
    ///
    /// By default pictures show the attributes that both meshes have.
    #[arg(long, help_heading = MEASURED, hide_short_help = true)]
    no_attributes: bool,
    /// Root mean square distance above D (or D%)
    ///
    /// Then the exit status is 1. Either way, from A to B and back; in A's unit, a percentage of
    /// A's diagonal.
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true,
          help_heading = DIFFERENCE)]
    max_rms: Option<Length>,
    /// Largest distance above D (or D%)
    ///
    /// Then the exit status is 1. In A's unit, a percentage of A's diagonal.
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true,
          help_heading = DIFFERENCE)]
    max_hausdorff: Option<Length>,
    /// Pictures that differ by more than GREY, 0 to 255
    ///
    /// Then the exit status is 1. Root mean square of all pixels.
    #[arg(long, value_name = "GREY", value_parser = grey, allow_negative_numbers = true,
          help_heading = DIFFERENCE)]
    max_image_rmse: Option<f64>,
    /// Levels worse than those recorded in FILE or DIR
    ///
    /// Then the exit status is 1. FILE is one document for all assets. DIR (one that is there, or a
    /// name with / at its end) has a file for each file of B.
    #[arg(long, value_name = "FILE|DIR", help_heading = DIFFERENCE)]
    baseline: Option<PathBuf>,
    /// Write the baseline instead of comparing with it
    #[arg(long, requires = "baseline", help_heading = DIFFERENCE)]
    record: bool,
    /// Share by which a number may be above the baseline
    #[arg(long, value_name = "SHARE", default_value = "2%", value_parser = share,
          help_heading = DIFFERENCE, hide_short_help = true)]
    tolerance: f64,
    /// Print one JSON document on standard output
    #[arg(long, help_heading = OUTPUT)]
    json: bool,
    /// Write a PNG: A and B from four sides, and how far each place of A is from B
    #[arg(long, value_name = "OUT.png", help_heading = OUTPUT)]
    heatmap: Option<PathBuf>,
    #[command(flatten)]
    ci: CiArgs,
    #[command(flatten)]
    batch: BatchArgs,
    #[command(flatten)]
    configuration: ConfigArgs,
    #[command(flatten)]
    import: ImportArgs,
}

const EXAMPLES: &str = "\
Both meshes are read as their default scenes show them, at rest. Distances are sampled: root mean \
squares use points spread evenly by area; the largest distance also uses vertices and a lattice on \
every triangle, and never exceeds the true one. Pictures have a lamp at the camera. Normals are \
those of the meshes if both have some, else smooth ones with sharp edges from 60 degrees on. \
Textures are compared in colour if both meshes have some; else, if both have texture \
coordinates, a checkerboard of 16 squares per unit shows where a texture would be stretched or \
has slipped.

Examples:
  lodc compare chair.glb chair.quarter.glb
  lodc compare chair.glb chair.glb --levels 50%,25%,10% --max-rms 0.5%
  lodc compare models levels --baseline numbers/ --junit results.xml";

/// A level of `--levels`.
#[derive(Clone, Debug)]
struct ComparedLevel {
    /// As it was typed.
    name: String,
    target: Target,
}

fn level(text: &str) -> Result<ComparedLevel, String> {
    Ok(ComparedLevel { name: text.to_owned(), target: size(text)? })
}

fn share(text: &str) -> Result<f64, String> {
    let length = length(text)?;
    Ok(if length.of_diagonal { length.value / 100.0 } else { length.value })
}

impl CompareArgs {
    /// The two paths; none with a list.
    fn named(&self) -> Option<[&Path; 2]> {
        Some([self.a.as_deref()?, self.b.as_deref()?])
    }

    /// Returns whether there may be several pairs.
    fn takes_many(&self) -> bool {
        self.named().is_none_or(|[a, _]| a.is_dir())
    }

    /// The limits that were given.
    fn limits_on_differences(&self) -> ComparisonLimits {
        let Self { max_rms: rms, max_hausdorff: hausdorff, max_image_rmse: image_rmse, .. } = *self;
        ComparisonLimits { rms, hausdorff, image_rmse }
    }

    /// The levels of B, with their names if there may be several.
    fn level_choices(&self) -> Vec<(Option<String>, LevelChoice)> {
        let per_object = self.level_b.per_object();
        let choice = |target| LevelChoice { target, per_object };
        if self.levels.is_empty() {
            return vec![(None, choice(self.level_b.target()))];
        }
        self.levels.iter().map(|l| (Some(l.name.clone()), choice(Some(l.target)))).collect()
    }
}

fn length(text: &str) -> Result<Length, String> {
    let (number, of_diagonal) =
        text.strip_suffix('%').map_or((text, false), |number| (number, true));
    match number.trim().parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(Length { value, of_diagonal }),
        _ => Err("not a number that is zero or more".to_owned()),
    }
}

fn grey(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if (0.0..=255.0).contains(&value) => Ok(value),
        _ => Err("not a number from 0 to 255".to_owned()),
    }
}

pub(crate) fn run(args: &CompareArgs, program: &Program) -> Outcome<Status> {
    print_failure(args.json, compare_all(args, program))
}

/// Checks that options fit together, and compares all pairs.
fn compare_all(args: &CompareArgs, program: &Program) -> Outcome<Status> {
    check(args)?;
    let baseline = baseline::open(args)?;
    let pairs = batch::pairs(args.named(), &args.batch)?;
    let (mut jobs, others): (Vec<Job>, Vec<_>) =
        pairs.into_iter().map(|Pair { job, compared_with }| (job, compared_with)).unzip();
    configure(args, program, &mut jobs, &others)?;
    let options = JobOptions::new(program, "compare", &jobs, |args: CompareArgs, _| args);
    let (several, bar) = (args.takes_many(), BatchProgress::new(jobs.len()));
    clock::expect_several(jobs.len() > 1);
    // One pair after the other: each uses all threads, and much memory for its pictures.
    let compare_pair = |(job, other): (&Job, Result<PathBuf, JobError>)| {
        let original_prefix = other.as_ref().ok().map(|path| format!("{}: ", path.display()));
        let work = || -> Outcome<_> {
            let (other, (args, _)) = (other?, options.ready(job)?);
            check_limits(args)?;
            let progress = bar.of_asset(&job.name);
            let (paths, baseline) = ([&*other, &*job.input], baseline.as_ref());
            let measured = measure::compare(args, paths, &job.name, baseline, &progress)?;
            print_measured(args, &measured, several)?;
            Ok(measured)
        };
        let done = each::guarded(&job.input, || match (work(), original_prefix) {
            // What names the original is not to name the input, too.
            (Err(failure), Some(prefix)) if failure.message.starts_with(&prefix) => {
                Ok(Err(failure))
            }
            (measured, _) => measured.map(Ok),
        });
        bar.done(&job.name);
        done.flatten().inspect_err(each::print)
    };
    let done = jobs.iter().zip(others).map(compare_pair).collect();
    drop(bar);
    finish(args, &jobs, baseline, done)
}

/// Adds the options of configurations: those of the files that are compared with, then those of the
/// files that are judged.
fn configure(
    args: &CompareArgs,
    program: &Program,
    jobs: &mut [Job],
    others: &[Result<PathBuf, JobError>],
) -> Outcome<()> {
    let folder = args.a.as_ref().filter(|a| a.is_dir());
    let original = |(job, other): (&Job, &Result<PathBuf, JobError>)| {
        let input = other.clone().unwrap_or_else(|_| job.input.clone());
        Job { input, folder: folder.cloned(), ..job.clone() }
    };
    let mut originals: Vec<Job> = jobs.iter().zip(others).map(original).collect();
    args.configuration.apply(program, "compare", &mut originals)?;
    for (job, original) in jobs.iter_mut().zip(originals) {
        job.options = original.options;
    }
    args.configuration.apply(program, "compare", jobs)
}

/// Checks that what is limited is measured.
fn check_limits(args: &CompareArgs) -> Outcome<()> {
    match args.max_image_rmse {
        Some(_) if args.views == 0 => {
            Err(Failure::usage("--max-image-rmse needs pictures: --views must be at least 1"))
        }
        _ => Ok(()),
    }
}

/// Checks that nothing is read or written twice.
fn check(args: &CompareArgs) -> Outcome<()> {
    args.level_b.check_distance()?;
    check_limits(args)?;
    let inputs: Vec<&PathBuf> = [&args.a, &args.b].into_iter().flatten().collect();
    if inputs.len() == 2 && inputs.iter().all(|path| output::is_standard_stream(path)) {
        return Err(Failure::usage("standard input can be read once only"));
    }
    let read_and_written = inputs.iter().copied().chain(&args.heatmap);
    args.ci.check(read_and_written.map(PathBuf::as_path))?;
    let Some(path) = &args.heatmap else { return Ok(()) };
    if args.takes_many() || args.levels.len() > 1 {
        return Err(Failure::usage("--heatmap shows two files and one level"));
    }
    if output::is_standard_stream(path) || inputs.contains(&path) {
        return Err(Failure::usage("--heatmap needs a file of its own"));
    }
    output::of_kind(path, "png")?;
    Ok(output::prepare_targets(&[Output::File(path.clone())], false)?)
}

/// Prints what was measured; with `-q` and several pairs only what exceeds a limit.
fn print_measured(args: &CompareArgs, measured: &Measured, several: bool) -> Outcome<()> {
    let report = &measured.report;
    let is_shown = !several || !report.ok || wants(Loudness::Normal);
    if !args.json && is_shown {
        console::result(report.text(several).trim_end())?;
    }
    for what in report.exceeded() {
        note(&format!("lodc: {}: {what}", report.b));
    }
    Ok(())
}

/// Comparisons as CI systems show them. A pair that could not be compared has the name of the file
/// that was to be judged.
fn suites(jobs: &[Job], done: &[Outcome<Measured>]) -> Vec<Suite> {
    let suite = |(job, measured): (&Job, &Outcome<Measured>)| match measured {
        Ok(measured) => measured.report.suite(),
        Err(failure) => {
            let verdict = Verdict::Error(failure.message.clone());
            let cases = vec![Case { name: "compare".to_owned(), verdict }];
            Suite { name: job.input.display().to_string(), cases }
        }
    };
    jobs.iter().zip(done).map(suite).collect()
}

/// Finishes a run: reports, baseline, documents. Returns the highest status.
fn finish(
    args: &CompareArgs,
    jobs: &[Job],
    baseline: Option<Baseline>,
    done: Vec<Outcome<Measured>>,
) -> Outcome<Status> {
    args.ci.publish("lodc compare", &suites(jobs, &done))?;
    let (mut worst, mut results, mut recorded) = (Status::Done, Vec::new(), Vec::new());
    for (job, measured) in jobs.iter().zip(done) {
        results.push(match measured {
            Ok(Measured { report, recorded: now }) => {
                recorded.push((job.name.clone(), now));
                worst = worst.max(if report.ok { Status::Done } else { Status::Difference });
                ResultReport::Done(report)
            }
            Err(failure) => {
                worst = worst.max(failure.status);
                ResultReport::Failed(FailureReport::of(&job.input, &failure))
            }
        });
    }
    if let Some(baseline) = baseline.filter(|_| args.record) {
        baseline::write(baseline, recorded)?;
    }
    let several = args.takes_many();
    if several {
        let ok = |r: &&ResultReport<PairReport>| matches!(r, ResultReport::Done(r) if r.ok);
        let ok = results.iter().filter(ok).count();
        note(&format!("{ok} passed, {} failed", results.len() - ok));
    }
    if args.json {
        results::print(several, worst, results)?;
    }
    Ok(worst)
}
