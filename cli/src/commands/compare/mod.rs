//! `lodc compare`: how far apart two meshes, or those of two folders, are, in space and in
//! pictures; with limits or numbers of the last time, a gate for pipelines.

mod baseline;
mod measure;
mod report;
mod suites;
mod surface;

use super::asset::SimplifyArgs;
use super::ci::CiArgs;
use super::each::{self, AssetOptions};
use crate::batch::{self, Asset, BatchArgs, Pair};
use crate::config::ConfigArgs;
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::limits::ImportArgs;
use crate::output::{self, Target as Output};
use crate::pose::PoseArgs;
use crate::program::Program;
use crate::progress::BatchProgress;
use crate::results::{self, FailureReport, ResultReport, reported};
use crate::selector::{SelectorArgs, size};
use crate::threads;
use baseline::Baseline;
use clap::Args;
use lodc_assets::AssetError;
use lodc_select::Target;
use measure::Measured;
use report::PairReport;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use surface::Wish;

/// Distances below this share of the diagonal are rounding: the heatmap shows none.
const ROUNDING: f64 = 1e-6;

/// Options of `compare`.
#[derive(Args, Clone, Debug)]
pub(crate) struct CompareArgs {
    /// The mesh to compare with: OBJ, glTF, GLB or .lodc; `-` for standard input; or a folder
    #[arg(required_unless_present = "manifest", conflicts_with = "manifest", requires = "b")]
    a: Option<PathBuf>,
    /// The mesh to be judged, or the asset whose level is: a mesh is then simplified in memory; or
    /// a folder, whose files are compared with those of A of the same path, with or without a
    /// further extension
    #[arg(required_unless_present = "manifest")]
    b: Option<PathBuf>,
    /// The level of A: a share (25%, 0.25) or a number (10k) of triangles [default: all]
    #[arg(long, value_name = "LEVEL", value_parser = size)]
    level_a: Option<Target>,
    #[command(flatten, next_help_heading = "Level of B [default: all triangles]")]
    level_b: SelectorArgs,
    /// Levels of B, each compared by itself: shares (25%, 0.25) or numbers (10k) of triangles
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = level,
          conflicts_with = "TargetArgs")]
    levels: Vec<Level>,
    #[command(flatten)]
    pose: PoseArgs,
    #[command(flatten)]
    simplify: SimplifyArgs,
    /// Print the result as JSON on standard output
    #[arg(long)]
    json: bool,
    /// Write a PNG: A and B from four sides, and how far each place of A is from B
    #[arg(long, value_name = "OUT.png")]
    heatmap: Option<PathBuf>,
    /// Exit 1 if the root mean square distance is greater, either way: in A's unit, or with `%` of
    /// its diagonal
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true)]
    max_rms: Option<Length>,
    /// Exit 1 if the largest distance found is greater, either way
    #[arg(long, value_name = "D", value_parser = length, allow_negative_numbers = true)]
    max_hausdorff: Option<Length>,
    /// Exit 1 if the root mean square difference of pixels (0 to 255) is greater
    #[arg(long, value_name = "GREY", value_parser = grey, allow_negative_numbers = true)]
    max_image_rmse: Option<f64>,
    /// Exit 1 if a distance or a difference of pixels is greater than the last time: as FILE has
    /// it or, for each file of B, a file in DIR
    #[arg(long, value_name = "FILE|DIR")]
    baseline: Option<PathBuf>,
    /// Write the baseline in place of comparing with it
    #[arg(long, requires = "baseline")]
    record: bool,
    /// A number counts as worse if it is more than this above the baseline: a share, or with `%`
    #[arg(long, value_name = "SHARE", default_value = "2%", value_parser = share)]
    tolerance: f64,
    #[command(flatten)]
    ci: CiArgs,
    /// Points spread over the area of each mesh
    #[arg(
        long,
        value_name = "N",
        default_value = "200000",
        value_parser = clap::value_parser!(u32).range(1..=100_000_000)
    )]
    samples: u32,
    /// Makes the points
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,
    /// Pictures, from all sides; 0 for none
    #[arg(
        long,
        value_name = "N",
        default_value = "24",
        value_parser = clap::value_parser!(u32).range(0..=1000)
    )]
    views: u32,
    /// Pixels across each picture
    #[arg(
        long,
        value_name = "N",
        default_value = "512",
        value_parser = clap::value_parser!(u32).range(16..=2048)
    )]
    size: u32,
    /// Look at shape only, not at normals, textures and texture coordinates that both meshes have
    #[arg(long)]
    no_attributes: bool,
    /// Threads; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    import: ImportArgs,
    #[command(flatten)]
    batch: BatchArgs,
    #[command(flatten)]
    configuration: ConfigArgs,
}

/// A level, as it was asked for.
#[derive(Clone, Debug)]
struct Level {
    name: String,
    target: Target,
}

fn level(text: &str) -> Result<Level, String> {
    Ok(Level { name: text.to_owned(), target: size(text)? })
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

    /// The levels of B, with their names if there may be several.
    fn wishes(&self) -> Vec<(Option<String>, Wish)> {
        let per_object = self.level_b.per_object();
        let wish = |target| Wish { target, per_object };
        if self.levels.is_empty() {
            return vec![(None, wish(self.level_b.target()))];
        }
        self.levels.iter().map(|l| (Some(l.name.clone()), wish(Some(l.target)))).collect()
    }
}

/// A length, possibly as a share of A's diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Length {
    value: f64,
    of_diagonal: bool,
}

impl Length {
    fn resolve(self, diagonal: f64) -> f64 {
        if self.of_diagonal { self.value / 100.0 * diagonal } else { self.value }
    }
}

fn length(text: &str) -> Result<Length, String> {
    let (number, of_diagonal) =
        text.strip_suffix('%').map_or((text, false), |number| (number, true));
    Ok(Length { value: grey(number)?, of_diagonal })
}

fn grey(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("not a number that is zero or more".to_owned()),
    }
}

pub(crate) fn run(args: &CompareArgs, program: &Program) -> Outcome<Status> {
    reported(args.json, checked(args, program))
}

/// Compares, once options are known to fit together.
fn checked(args: &CompareArgs, program: &Program) -> Outcome<Status> {
    check(args)?;
    let baseline = Baseline::open(args)?;
    let pairs = batch::pairs(args.named(), &args.batch)?;
    let (mut assets, others): (Vec<Asset>, Vec<_>) =
        pairs.into_iter().map(|Pair { asset, other }| (asset, other)).unzip();
    args.configuration.apply(program, "compare", &mut assets)?;
    let options = AssetOptions::new(program, "compare", &assets, |args: CompareArgs, _| args);
    let pool = threads::pool(args.jobs)?;
    let (several, bar) = (args.takes_many(), BatchProgress::new(assets.len()));
    // One after the other: each takes all threads, and much memory for its pictures.
    let one = |(asset, other): (&Asset, Result<PathBuf, AssetError>)| {
        let done = each::guarded(&asset.input, || {
            let (other, (args, _)) = (other?, options.ready(asset)?);
            let progress = bar.of_asset(&asset.name);
            let (paths, baseline) = ([&*other, &*asset.input], baseline.as_ref());
            let measured =
                pool.install(|| measure::compare(args, paths, &asset.name, baseline, &progress))?;
            say(args, &measured, several)?;
            Ok(measured)
        });
        bar.done(&asset.name);
        done.inspect_err(each::print)
    };
    let done = assets.iter().zip(others).map(one).collect();
    drop(bar);
    finish(args, &assets, baseline, done)
}

/// Checks that nothing is read or written twice.
fn check(args: &CompareArgs) -> Outcome<()> {
    args.level_b.check_distance()?;
    let inputs: Vec<&PathBuf> = [&args.a, &args.b].into_iter().flatten().collect();
    if inputs.len() == 2 && inputs.iter().all(|path| output::is_stream(path)) {
        return Err(Failure::usage("standard input can be read once only"));
    }
    args.ci.check(inputs.iter().copied())?;
    let Some(path) = &args.heatmap else { return Ok(()) };
    if args.takes_many() || args.levels.len() > 1 {
        return Err(Failure::usage("--heatmap shows two files and one level"));
    }
    if output::is_stream(path) || inputs.contains(&path) {
        return Err(Failure::usage("--heatmap needs a file of its own"));
    }
    Ok(output::prepare(&[Output::File(path.clone())], false)?)
}

/// Prints what was measured; of several with `-q` only what exceeds a limit.
fn say(args: &CompareArgs, measured: &Measured, several: bool) -> Outcome<()> {
    let report = &measured.report;
    let wanted = !several || !report.ok || wants(Loudness::Normal);
    if !args.json && wanted {
        console::result(report.text(several).trim_end())?;
    }
    for what in report.exceeded() {
        note(&format!("lodc: {}: {what}", report.b));
    }
    Ok(())
}

/// Ends a run: reports, baseline, documents. Returns the highest status.
fn finish(
    args: &CompareArgs,
    assets: &[Asset],
    baseline: Option<Baseline>,
    done: Vec<Outcome<Measured>>,
) -> Outcome<Status> {
    args.ci.publish("lodc compare", &suites::suites(assets, &done))?;
    let (mut worst, mut results, mut recorded) = (Status::Done, Vec::new(), Vec::new());
    for (asset, measured) in assets.iter().zip(done) {
        results.push(match measured {
            Ok(Measured { report, recorded: now }) => {
                recorded.push((asset.name.clone(), now));
                worst = worst.max(if report.ok { Status::Done } else { Status::Difference });
                ResultReport::Done(report)
            }
            Err(failure) => {
                worst = worst.max(failure.status);
                ResultReport::Failed(FailureReport::of(&asset.input, &failure))
            }
        });
    }
    if let Some(baseline) = baseline {
        baseline.write(recorded)?;
    }
    let several = args.takes_many();
    if several {
        let ok = |r: &&ResultReport<PairReport>| matches!(r, ResultReport::Done(r) if r.ok);
        let ok = results.iter().filter(ok).count();
        note(&format!("{ok} ok, {} not", results.len() - ok));
    }
    if args.json {
        results::print(several, worst, results)?;
    }
    Ok(worst)
}
