//! `lodc compare`: how far apart two meshes are, in space and in pictures; with limits, a gate for
//! pipelines.

mod heatmap;
mod report;
mod surface;

use super::asset::SimplifyArgs;
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::limits::ImportArgs;
use crate::output;
use crate::results::reported;
use crate::selector::{SelectorArgs, size};
use crate::stages::Stages;
use clap::Args;
use lodc_measure::{Looks, Sampling, SceneSurface, Viewing, compare_pictures, distances, pictures};
use lodc_select::Target;
use rayon::ThreadPoolBuilder;
use report::{CompareReport, ImageReport};
use std::num::NonZeroUsize;
use std::path::PathBuf;
use surface::{Wish, surface};

/// Distances below this share of the diagonal are rounding: the heatmap shows none.
const ROUNDING: f64 = 1e-6;

/// Options of `compare`.
#[derive(Args, Debug)]
pub(crate) struct CompareArgs {
    /// The mesh to compare with: OBJ, glTF, GLB or .lodc; `-` for standard input
    a: PathBuf,
    /// The mesh to be judged, or the asset whose level is: a mesh is then simplified in memory
    b: PathBuf,
    /// The level of A: a share (25%, 0.25) or a number (10k) of triangles [default: all]
    #[arg(long, value_name = "LEVEL", value_parser = size)]
    level_a: Option<Target>,
    #[command(flatten, next_help_heading = "Level of B [default: all triangles]")]
    level_b: SelectorArgs,
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

pub(crate) fn run(args: &CompareArgs) -> Outcome<Status> {
    reported(args.json, checked(args))
}

/// Compares, once options are known to fit together.
fn checked(args: &CompareArgs) -> Outcome<Status> {
    args.level_b.check_distance()?;
    if [&args.a, &args.b].iter().all(|path| output::is_stream(path)) {
        return Err(Failure::usage("standard input can be read once only"));
    }
    let heatmap = args.heatmap.as_ref().map(|path| output::Target::File(path.clone()));
    if let Some(output::Target::File(path)) = &heatmap {
        if output::is_stream(path) || [&args.a, &args.b].contains(&path) {
            return Err(Failure::usage("--heatmap needs a file of its own"));
        }
        output::prepare(&[output::Target::File(path.clone())], false)?;
    }
    let threads = args.jobs.map_or(0, |n| n.get().min(super::build::MOST_THREADS));
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool =
        pool.map_err(|e| Failure::new(Status::Limit, format!("no threads to work with: {e}")))?;
    pool.install(|| compare(args, heatmap.as_ref()))
}

fn compare(args: &CompareArgs, heatmap: Option<&output::Target>) -> Outcome<Status> {
    let mut stages = Stages::default();
    let wish_a = Wish { target: args.level_a, per_object: false };
    let wish_b = Wish { target: args.level_b.target(), per_object: args.level_b.per_object() };
    let a = surface(&args.a, wish_a, args, &mut stages)?;
    let b = surface(&args.b, wish_b, args, &mut stages)?;
    let looks = looks(&a, &b, args);
    let (a, b) = (a.surface, b.surface);
    let sampling =
        Sampling { samples: args.samples as usize, seed: args.seed, ..Sampling::DEFAULT };
    let space = stages.run("distance", || distances(&a, &b, &sampling));
    let image = (args.views > 0).then(|| {
        let viewing = Viewing { views: args.views, size: args.size };
        stages.run("pictures", || {
            let cameras = viewing.cameras(&a);
            let error =
                compare_pictures(&pictures(&a, &cameras, looks), &pictures(&b, &cameras, looks));
            ImageReport::new(viewing, looks, error)
        })
    });
    let mut report =
        CompareReport::new(a.diagonal(), [a.triangles.len(), b.triangles.len()], space, image);
    report.check(args);
    if let Some(target) = heatmap {
        stages.run("heatmap", || {
            output::write(
                target,
                heatmap::draw(&a, &b, looks, space.hausdorff[0].max(ROUNDING * a.diagonal())),
            )
        })?;
    }
    if args.json {
        console::json(&report)?;
    } else {
        console::result(report.text().trim_end())?;
    }
    for what in &report.exceeded {
        if wants(Loudness::Normal) {
            note(&format!("lodc: {}: {what}", args.b.display()));
        }
    }
    Ok(if report.ok { Status::Done } else { Status::Difference })
}

/// Everything that both meshes can be shown with.
fn looks(a: &SceneSurface, b: &SceneSurface, args: &CompareArgs) -> Looks {
    let both = |has: fn(&SceneSurface) -> bool| !args.no_attributes && has(a) && has(b);
    let materials = both(|s| !s.surface.materials.is_empty());
    Looks {
        own_normals: both(|s| !s.surface.normals.is_empty()),
        checkerboard: !materials && both(|s| s.all_textured),
        materials,
    }
}
