//! A crowd that walks around a viewer (thesis 4.4.2, figs. 4.11 to 4.14): every instance has a
//! level by its distance, of all levels or of five, and a cursor of its own.

mod walk;

use super::subject::{Runner, Structure, baselines, structures};
use super::{BenchArgs, Prepared};
use crate::exit::Outcome;
use crate::text::grouped;
use clap::Args;
use lodc_baseline::{Baseline, Discrete};
use lodc_formats::lodc::LodObject;
use lodc_mesh::{CollapseSequence, Lod};
use lodc_strip::StripKind;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;
use walk::{Crowd, FRAMES_PER_SECOND};

/// Options of a crowd.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct CrowdArgs {
    /// Measure a crowd of all inputs instead, in turn: it walks around a viewer, ten frames a
    /// second, and every instance has a level by its distance
    #[arg(long, conflicts_with_all = ["gpu", "streams"])]
    pub(super) crowd: bool,
    /// Instances of a crowd
    #[arg(long, value_name = "N", default_value = "250", requires = "crowd",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    instances: u32,
    /// Seconds that it walks
    #[arg(long, value_name = "S", default_value = "50", requires = "crowd",
          value_parser = clap::value_parser!(u32).range(1..=10_000))]
    seconds: u32,
    /// Makes its paths
    #[arg(long, value_name = "K", default_value = "1", requires = "crowd")]
    seed: u64,
}

/// `crowd` of `bench --json`.
#[derive(Debug, Serialize)]
pub(super) struct CrowdReport {
    instances: u32,
    frames: u32,
    seed: u64,
    models: BTreeMap<&'static str, Policies>,
    /// Everything at LOD 0.
    none: Frames,
}

/// A structure with levels by distance.
#[derive(Debug, Serialize)]
struct Policies {
    /// Every LOD.
    continuous: Frames,
    /// Five levels, each with 25 % fewer triangles than the one before.
    discrete: Frames,
}

/// Means over frames.
#[derive(Clone, Copy, Debug, Serialize)]
struct Frames {
    triangles_per_frame: f64,
    /// Null with `--no-times`.
    extraction_ms_per_frame: Option<f64>,
    /// Share of the instances whose level another one of the same input has in the same frame.
    shared: f64,
    /// Share of the instances whose level is another one than in the frame before.
    changed: f64,
}

/// The levels of everyone in every frame.
struct Levels {
    /// By frame, then by instance; an instance of several objects has several.
    lods: Vec<Vec<Vec<Lod>>>,
    frames: Frames,
}

/// Lets a crowd of some inputs walk. Each input is its objects.
///
/// # Errors
/// If a baseline cannot be made: a bug.
pub(super) fn measure(args: &BenchArgs, inputs: &[Vec<Prepared>]) -> Outcome<CrowdReport> {
    let CrowdArgs { instances, seconds, seed, .. } = args.crowd;
    let frames = seconds * FRAMES_PER_SECOND;
    let baselines: Vec<Vec<Vec<Baseline>>> = inputs
        .iter()
        .map(|objects| {
            objects.iter().map(|o| baselines(&o.object, o.strips(StripKind::LONGEST))).collect()
        })
        .collect::<Outcome<_>>()?;
    let distances = distances(instances, frames, seed);
    let [continuous, discrete, none] = [at_distance, of_five, |_: &CollapseSequence, _| Lod(0)]
        .map(|policy: fn(&CollapseSequence, f64) -> Lod| levels(inputs, &distances, policy));
    let mut models = BTreeMap::new();
    for name in names(inputs, &baselines) {
        let run = |levels: &Levels| Frames {
            extraction_ms_per_frame: (!args.no_times)
                .then(|| extraction(name, inputs, &baselines, levels, args.rounds.get())),
            ..levels.frames
        };
        let policies = Policies { continuous: run(&continuous), discrete: run(&discrete) };
        models.insert(name, policies);
    }
    let nothing = (!args.no_times).then_some(0.0);
    let none = Frames { extraction_ms_per_frame: nothing, ..none.frames };
    Ok(CrowdReport { instances, frames, seed, models, none })
}

/// The names of all structures that every object of every input has.
fn names(inputs: &[Vec<Prepared>], baselines: &[Vec<Vec<Baseline>>]) -> Vec<&'static str> {
    let first = inputs.iter().zip(baselines).find(|(objects, _)| !objects.is_empty());
    first.map_or_else(Vec::new, |(objects, baselines)| {
        structures(&objects[0].object, &baselines[0]).iter().map(Structure::name).collect()
    })
}

/// Distances of everyone in every frame, the start included.
fn distances(instances: u32, frames: u32, seed: u64) -> Vec<Vec<f64>> {
    let mut crowd = Crowd::new(instances, seed);
    let mut all = vec![crowd.distances()];
    for _ in 0..frames {
        crowd.step();
        all.push(crowd.distances());
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
    inputs: &[Vec<Prepared>],
    distances: &[Vec<f64>],
    policy: fn(&CollapseSequence, f64) -> Lod,
) -> Levels {
    let of = |(i, &distance): (usize, &f64)| -> Vec<Lod> {
        let objects = inputs[i % inputs.len()].iter();
        objects.map(|o| policy(o.object.simplified.collapses(), distance)).collect()
    };
    let frame = |all: &Vec<f64>| all.iter().enumerate().map(of).collect::<Vec<_>>();
    let lods: Vec<Vec<Vec<Lod>>> = distances.iter().map(frame).collect();
    let (mut triangles, mut shared, mut changed) = (0, 0, 0);
    for pair in lods.windows(2) {
        let mut seen: BTreeMap<(usize, &[Lod]), u64> = BTreeMap::new();
        for (i, (before, now)) in pair[0].iter().zip(&pair[1]).enumerate() {
            let input = i % inputs.len();
            let of = inputs[input].iter().zip(now);
            triangles += of
                .map(|(o, &lod)| u64::from(o.object.simplified.collapses().triangles_at(lod)))
                .sum::<u64>();
            changed += u64::from(before != now);
            *seen.entry((input, now)).or_default() += 1;
        }
        shared += seen.values().filter(|&&n| n > 1).sum::<u64>();
    }
    let frames = (lods.len() - 1) as f64;
    let all = frames * distances[0].len() as f64;
    let frames = Frames {
        triangles_per_frame: triangles as f64 / frames,
        extraction_ms_per_frame: None,
        shared: shared as f64 / all,
        changed: changed as f64 / all,
    };
    Levels { lods, frames }
}

/// Mean milliseconds of a frame in which every cursor of a structure goes where its instance is, of
/// the best round.
fn extraction(
    name: &str,
    inputs: &[Vec<Prepared>],
    baselines: &[Vec<Vec<Baseline>>],
    levels: &Levels,
    rounds: u32,
) -> f64 {
    let cursors = |i: usize| -> Vec<_> {
        let input = i % inputs.len();
        let objects = inputs[input].iter().zip(&baselines[input]);
        objects.filter_map(|(o, baselines)| cursor(name, &o.object, baselines)).collect()
    };
    let mut crowd: Vec<Vec<_>> = (0..levels.lods[0].len()).map(cursors).collect();
    let mut move_all = |frame: &[Vec<Lod>]| -> u64 {
        let everyone = crowd.iter_mut().flatten().zip(frame.iter().flatten());
        everyone.map(|(cursor, &lod)| cursor.seek(lod).rewritten).sum()
    };
    let mut best = f64::INFINITY;
    for _ in 0..rounds {
        // The way to where everyone starts is no part of it.
        black_box(move_all(&levels.lods[0]));
        let start = Instant::now();
        for frame in &levels.lods[1..] {
            black_box(move_all(frame));
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    best * 1e3 / (levels.lods.len() - 1) as f64
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
    text
}
