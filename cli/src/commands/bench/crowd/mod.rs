//! A crowd that walks around a viewer (thesis 4.4.2, figs. 4.11 to 4.14): every instance has a
//! level by its distance, of all levels or of five, and a cursor of its own.

#[cfg(feature = "gpu")]
mod draws;
#[cfg(feature = "gpu")]
mod figures;
#[cfg(feature = "gpu")]
mod picture;
mod plots;
mod report;
mod walk;

pub(super) use report::CrowdReport;

use super::measure::means;
use super::subject::{Runner, Structure, baselines, structures};
use super::{BenchArgs, Input, Prepared};
use crate::exit::Outcome;
use crate::gpu::Device;
use crate::help::{MEASURED, OUTPUT};
use crate::text::grouped;
use clap::Args;
use lodc_baseline::{Baseline, Discrete};
use lodc_formats::lodc::LodObject;
use lodc_mesh::{CollapseSequence, Lod};
use lodc_strip::StripKind;
use report::{CrowdCurve, Frames, Policies};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;
use walk::{Crowd, FRAMES_PER_SECOND, Stand};

/// Options of a crowd.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = MEASURED)]
pub(super) struct CrowdArgs {
    /// Measure a crowd of all inputs instead
    ///
    /// It walks around a viewer, ten frames a second; every instance has a level by its distance.
    #[arg(long, conflicts_with = "streams")]
    pub(super) crowd: bool,
    /// Instances of the crowd, up to 100,000
    #[arg(long, value_name = "N", default_value = "250", requires = "crowd",
          value_parser = clap::value_parser!(u32).range(1..=100_000), hide_short_help = true)]
    instances: u32,
    /// Seconds that it walks, up to 10,000
    #[arg(long, value_name = "S", default_value = "50", requires = "crowd",
          value_parser = clap::value_parser!(u32).range(1..=10_000), hide_short_help = true)]
    seconds: u32,
    /// Number that makes its paths; the same one gives the same paths
    #[arg(long, value_name = "K", default_value = "1", requires = "crowd", hide_short_help = true)]
    seed: u64,
    /// Draw the crowd in the middle of its time, by level, on a graphics device
    #[arg(long, value_name = "OUT.png", requires = "crowd", help_heading = OUTPUT,
          hide_short_help = true)]
    pub(super) picture: Option<PathBuf>,
}

/// The levels of everyone in every frame.
struct CrowdLevels {
    /// By frame, then by instance; an instance of several objects has several.
    lods: Vec<Vec<Vec<Lod>>>,
    /// Triangles of each frame but the first.
    triangles: Vec<f64>,
    frames: Frames,
}

/// Lets a crowd of some inputs walk.
///
/// # Errors
/// If a baseline cannot be made (a bug), a graphics device fails, or a file cannot be written.
pub(super) fn measure(
    args: &BenchArgs,
    device: Option<&Device>,
    inputs: &[Input],
) -> Outcome<CrowdReport> {
    let CrowdArgs { instances, seconds, seed, .. } = args.crowd;
    let frames = seconds * FRAMES_PER_SECOND;
    let baselines: Vec<Vec<Vec<Baseline>>> = inputs
        .iter()
        .map(|input| {
            let strips = |o: &Prepared| baselines(&o.object, o.strips(StripKind::LONGEST));
            input.objects.iter().map(strips).collect()
        })
        .collect::<Outcome<_>>()?;
    let stands = stands(instances, frames, seed);
    let [continuous, discrete, none] = [at_distance, of_five, |_: &CollapseSequence, _| Lod(0)]
        .map(|policy: fn(&CollapseSequence, f64) -> Lod| levels(inputs, &stands, policy));
    let mut models = BTreeMap::new();
    for name in names(inputs, &baselines) {
        let run = |levels: &CrowdLevels| {
            let frames = levels.frames.clone();
            if args.no_times {
                return frames;
            }
            let rounds = extraction(name, inputs, &baselines, levels, args.rounds.get());
            let of = |round: &Vec<f64>| round.iter().sum::<f64>() / round.len() as f64;
            let least =
                |f: usize| rounds.iter().map(|round| round[f]).fold(f64::INFINITY, f64::min);
            let times: Vec<f64> = (0..rounds[0].len()).map(least).collect();
            Frames {
                extraction_ms_per_frame: rounds.iter().map(of).min_by(f64::total_cmp),
                extraction_ms_curve: Some(means(&times)),
                ..frames
            }
        };
        let policies = Policies { continuous: run(&continuous), discrete: run(&discrete) };
        models.insert(name, policies);
    }
    let second: Vec<f64> =
        (1..=frames).map(|f| f64::from(f) / f64::from(FRAMES_PER_SECOND)).collect();
    let curve = CrowdCurve {
        seconds: super::measure::points(&second),
        continuous: means(&continuous.triangles),
        discrete: means(&discrete.triangles),
        none: means(&none.triangles),
    };
    let gpu = on_device(args, device, inputs, &stands, [&continuous, &discrete, &none])?;
    let nothing = (!args.no_times).then_some(0.0);
    let none = Frames { extraction_ms_per_frame: nothing, ..none.frames };
    Ok(CrowdReport { instances, frames, seed, models, none, curve, gpu })
}

/// Draws the picture that was asked for, and times draws of frames.
///
/// # Errors
/// If the device fails or is too small, or the picture cannot be written.
#[cfg(feature = "gpu")]
fn on_device(
    args: &BenchArgs,
    device: Option<&Device>,
    inputs: &[Input],
    stands: &[Vec<Stand>],
    levels: [&CrowdLevels; 3],
) -> Outcome<Option<report::CrowdOnDevice>> {
    use crate::output;
    let Some(device) = device else { return Ok(None) };
    let limits = args.import.options().limits;
    let figures = inputs.iter().zip(&args.inputs);
    let mut figures: Vec<figures::Figure<'_>> = figures
        .map(|(input, path)| figures::Figure::new(input, path, &limits))
        .collect::<Outcome<_>>()?;
    if let Some(out) = &args.crowd.picture {
        let target = output::Target::File(out.clone());
        let picture = picture::picture(device, &mut figures, stands, &levels[0].lods)?;
        output::write(&target, lodc_formats::picture::png(&picture))?;
    }
    if args.gpu.gpu.is_none() || args.no_times {
        return Ok(None);
    }
    draws::measure(device, &mut figures, stands, levels, args.rounds.get()).map(Some)
}

/// There is no device.
///
/// # Errors
/// Never.
#[cfg(not(feature = "gpu"))]
fn on_device(
    _: &BenchArgs,
    device: Option<&Device>,
    _: &[Input],
    _: &[Vec<Stand>],
    _: [&CrowdLevels; 3],
) -> Outcome<Option<report::CrowdOnDevice>> {
    device.map(|device| match *device {}).transpose()
}

/// Charts of a crowd, as names of files and what is in them.
pub(super) fn plots(report: &CrowdReport) -> Vec<(&'static str, String)> {
    plots::plots(report)
}

/// The names of all structures that every object of every input has.
fn names(inputs: &[Input], baselines: &[Vec<Vec<Baseline>>]) -> Vec<&'static str> {
    let first = inputs.iter().zip(baselines).find(|(input, _)| !input.objects.is_empty());
    first.map_or_else(Vec::new, |(input, baselines)| {
        structures(&input.objects[0].object, &baselines[0]).iter().map(Structure::name).collect()
    })
}

/// The places of everyone in every frame, the start included.
fn stands(instances: u32, frames: u32, seed: u64) -> Vec<Vec<Stand>> {
    let mut crowd = Crowd::new(instances, seed);
    let mut all = vec![crowd.stands()];
    for _ in 0..frames {
        crowd.step();
        all.push(crowd.stands());
    }
    all
}

/// The LOD at a distance from 0 to 1 (the criterion of 3.1): linear in records, down to the last
/// one that has a triangle.
fn at_distance(collapses: &CollapseSequence, distance: f64) -> Lod {
    let last = f64::from(collapses.last_visible().0);
    collapses.floor(Lod((last * distance) as u32))
}

/// The discrete level at a distance, each for a fifth of it.
fn of_five(collapses: &CollapseSequence, distance: f64) -> Lod {
    let levels = lodc_baseline::LEVELS;
    let level = ((distance * levels as f64) as usize).min(levels - 1);
    Discrete::lod(collapses, level)
}

/// The levels of everyone by a policy.
fn levels(
    inputs: &[Input],
    stands: &[Vec<Stand>],
    policy: fn(&CollapseSequence, f64) -> Lod,
) -> CrowdLevels {
    let of = |(i, stand): (usize, &Stand)| -> Vec<Lod> {
        let objects = inputs[i % inputs.len()].objects.iter();
        objects.map(|o| policy(o.object.simplified.collapses(), stand.distance)).collect()
    };
    let frame = |all: &Vec<Stand>| all.iter().enumerate().map(of).collect::<Vec<_>>();
    let lods: Vec<Vec<Vec<Lod>>> = stands.iter().map(frame).collect();
    let (mut triangles, mut shared, mut changed) = (Vec::new(), 0, 0);
    for pair in lods.windows(2) {
        let mut seen: BTreeMap<(usize, &[Lod]), u64> = BTreeMap::new();
        let mut drawn = 0;
        for (i, (before, now)) in pair[0].iter().zip(&pair[1]).enumerate() {
            let input = i % inputs.len();
            let of = inputs[input].objects.iter().zip(now);
            drawn += of
                .map(|(o, &lod)| u64::from(o.object.simplified.collapses().triangles_at(lod)))
                .sum::<u64>();
            changed += u64::from(before != now);
            *seen.entry((input, now)).or_default() += 1;
        }
        triangles.push(drawn as f64);
        shared += seen.values().filter(|&&n| n > 1).sum::<u64>();
    }
    let all = (triangles.len() * stands[0].len()) as f64;
    let frames = Frames {
        triangles_per_frame: triangles.iter().sum::<f64>() / triangles.len() as f64,
        extraction_ms_per_frame: None,
        extraction_ms_curve: None,
        shared: shared as f64 / all,
        changed: changed as f64 / all,
    };
    CrowdLevels { lods, triangles, frames }
}

/// Milliseconds, by round and frame, in which every cursor of a structure goes where its instance
/// is.
fn extraction(
    name: &str,
    inputs: &[Input],
    baselines: &[Vec<Vec<Baseline>>],
    levels: &CrowdLevels,
    rounds: u32,
) -> Vec<Vec<f64>> {
    let cursors = |i: usize| -> Vec<_> {
        let input = i % inputs.len();
        let objects = inputs[input].objects.iter().zip(&baselines[input]);
        objects.filter_map(|(o, baselines)| cursor(name, &o.object, baselines)).collect()
    };
    let mut crowd: Vec<Vec<_>> = (0..levels.lods[0].len()).map(cursors).collect();
    let mut move_all = |frame: &[Vec<Lod>]| -> f64 {
        let start = Instant::now();
        let everyone = crowd.iter_mut().flatten().zip(frame.iter().flatten());
        black_box(everyone.map(|(cursor, &lod)| cursor.seek(lod).rewritten).sum::<u64>());
        start.elapsed().as_secs_f64() * 1e3
    };
    let round = |_| -> Vec<f64> {
        // The way to where everyone starts is no part of it.
        move_all(&levels.lods[0]);
        levels.lods[1..].iter().map(|frame| move_all(frame)).collect()
    };
    (0..rounds).map(round).collect()
}

/// A new cursor over one structure of an object.
fn cursor<'a>(
    name: &str,
    object: &'a LodObject,
    baselines: &'a [Baseline],
) -> Option<Box<dyn Runner + 'a>> {
    let all = structures(object, baselines);
    all.iter().find(|s| s.name() == name).map(Structure::runner)
}

/// The report as people read it.
pub(super) fn text(report: &CrowdReport) -> String {
    let mut text = format!(
        "{} instances, {} frames: per frame\n{:<18} {:>14} {:>12} {:>8}\n",
        grouped(u64::from(report.instances)),
        grouped(u64::from(report.frames)),
        "",
        "triangles",
        "ms",
        "shared"
    );
    let mut row = |name: &str, frames: &Frames| {
        let ms = frames.extraction_ms_per_frame.map_or("–".to_owned(), |ms| format!("{ms:.3}"));
        let triangles = grouped(frames.triangles_per_frame.round() as u64);
        // Writing to a string cannot fail.
        let shared = frames.shared * 100.0;
        let _ = writeln!(text, "{name:<18} {triangles:>14} {ms:>12} {shared:>6.1} %");
    };
    for (name, policies) in &report.models {
        row(name, &policies.continuous);
        row("  five levels", &policies.discrete);
    }
    row("no levels", &report.none);
    if let Some(gpu) = &report.gpu {
        let frames = grouped(u64::from(gpu.frames));
        let _ = writeln!(
            text,
            "\n{}, {frames} frames drawn: per frame\n{:<18} {:>14} {:>12} {:>8} {:>12}",
            gpu.adapter, "", "triangles", "ms", "draws", "index bytes"
        );
        let rows = [
            ("continuous", gpu.continuous),
            ("five levels", gpu.discrete),
            ("no levels", gpu.none),
        ];
        for (name, frames) in rows {
            let [triangles, draws, bytes] =
                [frames.triangles_per_frame, frames.draws_per_frame, frames.index_bytes_per_frame]
                    .map(|n| grouped(n.round() as u64));
            let ms = frames.draw_ms_per_frame;
            let _ = writeln!(text, "{name:<18} {triangles:>14} {ms:>12.3} {draws:>8} {bytes:>12}");
        }
    }
    text
}
