//! A crowd that walks around a viewer (thesis 4.4.2, figs. 4.11 to 4.14): every instance has a
//! level by its distance, of all levels or of five, and a cursor of its own.

#[cfg(feature = "gpu")]
mod draws;
mod figures;
mod picture;
mod plots;
mod report;
mod walk;

pub use plots::crowd_charts;
pub use report::CrowdReport;

use crate::baseline::{Baseline, Discrete, LEVELS};
use crate::device::Device;
use crate::error::LabError;
use crate::prepared::{Input, Prepared};
use crate::structures::{Runner, Structure, baselines, structures};
use crate::sweep::{means, points};
use crate::timings::Timings;
use lodc::LodObject;
use lodc_formats::Limits;
use lodc_mesh::{CollapseSequence, Lod};
use lodc_report::text::grouped;
use lodc_scene::Image;
use lodc_strip::StripKind;
use report::{CrowdCurve, CrowdOnDevice, DistanceCurve, Frames, Policies};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;
use walk::{Crowd, FRAMES_PER_SECOND, WalkerPosition};

/// A crowd, and how it is measured.
#[derive(Clone, Copy, Debug)]
pub struct CrowdSettings {
    /// Number of walkers: the inputs in turn.
    pub instances: u32,
    /// The time that they walk, ten frames a second.
    pub seconds: u32,
    /// Makes their paths.
    pub seed: u64,
    /// Rounds of timing, of which the best counts; with none nothing is timed.
    pub rounds: Option<u32>,
    /// Limits on the inputs' scenes and animations.
    pub limits: Limits,
}

/// The levels of everyone in every frame.
struct CrowdLevels {
    /// By frame, then by instance; an instance of several objects has several.
    lods: Vec<Vec<Vec<Lod>>>,
    /// Triangles of each frame but the first.
    triangles: Vec<f64>,
    frames: Frames,
}

/// Lets a crowd of some inputs walk. Where there is a device, frames are drawn on it and timed.
///
/// # Errors
/// If a baseline cannot be made (a bug), a scene or an animation is damaged, or the device fails or
/// is too small.
pub fn crowd(
    inputs: &[Input],
    settings: &CrowdSettings,
    device: Option<&Device>,
) -> Result<CrowdReport, LabError> {
    let CrowdSettings { instances, seconds, seed, rounds, .. } = *settings;
    let frames = seconds * FRAMES_PER_SECOND;
    let object_baselines = |o: &Prepared| baselines(&o.object, o.strips(StripKind::LONGEST));
    let baselines_of = |input: &Input| input.objects.iter().map(object_baselines).collect();
    let baselines: Vec<Vec<Vec<Baseline>>> =
        inputs.iter().map(baselines_of).collect::<Result<_, LabError>>()?;
    let positions = positions(instances, frames, seed);
    let [continuous, discrete, none] =
        [continuous_lod, discrete_lod, |_: &CollapseSequence, _| Lod(0)]
            .map(|policy: Policy| levels(inputs, &positions, policy));
    let mut models = BTreeMap::new();
    for name in names(inputs, &baselines) {
        models.insert(name, [FrameTimes::default(), FrameTimes::default()]);
    }
    // All structures take turns, round after round: a busy machine is busy for all of them.
    for _ in 0..rounds.unwrap_or(0) {
        for (name, timed) in &mut models {
            for (timed, levels) in timed.iter_mut().zip([&continuous, &discrete]) {
                timed.rounds.push(extraction(name, inputs, &baselines, levels));
            }
        }
    }
    let models = models.into_iter().map(|(name, [all, five])| {
        let continuous = all.frames(&continuous.frames);
        (name, Policies { continuous, discrete: five.frames(&discrete.frames) })
    });
    let models = models.collect();
    let second: Vec<f64> =
        (1..=frames).map(|f| f64::from(f) / f64::from(FRAMES_PER_SECOND)).collect();
    let curve = CrowdCurve {
        seconds: points(&second),
        continuous: means(&continuous.triangles),
        discrete: means(&discrete.triangles),
        none: means(&none.triangles),
    };
    let levels = [&continuous, &discrete, &none];
    let gpu = device.zip(rounds);
    let gpu =
        gpu.map(|(device, rounds)| drawn(device, inputs, settings, &positions, levels, rounds));
    let none = Frames { extraction_ms_per_frame: rounds.map(|_| 0.0), ..none.frames };
    let by_distance = by_distance(inputs);
    let gpu = gpu.transpose()?;
    Ok(CrowdReport { instances, frames, seed, models, none, curve, by_distance, gpu })
}

/// Milliseconds of moving all cursors.
#[derive(Default)]
struct FrameTimes {
    /// By round, then by frame.
    rounds: Vec<Vec<f64>>,
}

impl FrameTimes {
    /// Figures of frames, with what they took if they were timed.
    fn frames(&self, untimed: &Frames) -> Frames {
        let Some(first) = self.rounds.first() else { return untimed.clone() };
        let mean = |round: &Vec<f64>| round.iter().sum::<f64>() / round.len() as f64;
        let rounds: Timings = self.rounds.iter().map(mean).collect();
        let least =
            |f: usize| self.rounds.iter().map(|round| round[f]).fold(f64::INFINITY, f64::min);
        let times: Vec<f64> = (0..first.len()).map(least).collect();
        Frames {
            extraction_ms_per_frame: Some(rounds.best()),
            extraction_spread: Some(rounds.spread()),
            extraction_ms_curve: Some(means(&times)),
            ..untimed.clone()
        }
    }
}

/// Triangles of a figure, the mean of all inputs, at distances from 0 to 1.
fn by_distance(inputs: &[Input]) -> DistanceCurve {
    const POINTS: usize = 100;
    let distance: Vec<f64> = (0..=POINTS).map(|i| i as f64 / POINTS as f64).collect();
    let triangles_by = |policy: Policy| -> Vec<f64> {
        let at = |&distance: &f64| -> f64 {
            let objects = inputs.iter().flat_map(|input| &input.objects);
            let triangles = objects.map(|o| {
                let collapses = o.object.simplified.collapses();
                f64::from(collapses.triangles_at(policy(collapses, distance)))
            });
            triangles.sum::<f64>() / inputs.len().max(1) as f64
        };
        distance.iter().map(at).collect()
    };
    let (continuous, discrete) = (triangles_by(continuous_lod), triangles_by(discrete_lod));
    DistanceCurve { none: triangles_by(|_, _| Lod(0)), continuous, discrete, distance }
}

/// Times draws of frames.
#[cfg(feature = "gpu")]
fn drawn(
    device: &Device,
    inputs: &[Input],
    settings: &CrowdSettings,
    positions: &[Vec<WalkerPosition>],
    levels: [&CrowdLevels; 3],
    rounds: u32,
) -> Result<CrowdOnDevice, LabError> {
    draws::measure(device, &mut figures::all(inputs, &settings.limits)?, positions, levels, rounds)
}

/// There is no device.
#[cfg(not(feature = "gpu"))]
fn drawn(
    device: &Device,
    _: &[Input],
    _: &CrowdSettings,
    _: &[Vec<WalkerPosition>],
    _: [&CrowdLevels; 3],
    _: u32,
) -> Result<CrowdOnDevice, LabError> {
    match *device {}
}

/// Draws the crowd in the middle of its time by all levels and by five, side by side, coloured by
/// level: from blue (every triangle) to red (none).
///
/// # Errors
/// If a scene or an animation is damaged.
pub fn crowd_picture(inputs: &[Input], settings: &CrowdSettings) -> Result<Image, LabError> {
    let frames = settings.seconds * FRAMES_PER_SECOND;
    let all = positions(settings.instances, frames, settings.seed);
    let now = all.len() / 2;
    let policies: [(&str, Policy); 2] =
        [("continuous", continuous_lod), ("five levels", discrete_lod)];
    let policies = policies.map(|(name, policy)| (name, lods(inputs, &all[now], policy)));
    let mut figures = figures::all(inputs, &settings.limits)?;
    Ok(picture::picture(&mut figures, &all[now], &policies, now))
}

/// The names of all structures that every object of every input has.
fn names(inputs: &[Input], baselines: &[Vec<Vec<Baseline>>]) -> Vec<&'static str> {
    let first = inputs.iter().zip(baselines).find(|(input, _)| !input.objects.is_empty());
    first.map_or_else(Vec::new, |(input, baselines)| {
        structures(&input.objects[0].object, &baselines[0]).iter().map(Structure::name).collect()
    })
}

/// Where everyone is in every frame, the start included.
fn positions(instances: u32, frames: u32, seed: u64) -> Vec<Vec<WalkerPosition>> {
    let mut crowd = Crowd::new(instances, seed);
    let mut all = vec![crowd.positions()];
    for _ in 0..frames {
        crowd.advance();
        all.push(crowd.positions());
    }
    all
}

/// The LOD at a distance from 0 to 1: where a discrete level begins, that level; from there to
/// where the next begins, linear in records (thesis 3.1).
fn continuous_lod(collapses: &CollapseSequence, distance: f64) -> Lod {
    let position = distance * LEVELS as f64;
    let level = (position as usize).min(LEVELS - 1);
    let [from, to] = [level, level + 1].map(|level| f64::from(Discrete::lod(collapses, level).0));
    let lod = from + (to - from) * (position - level as f64).clamp(0.0, 1.0);
    collapses.floor(Lod(lod as u32)).min(collapses.last_visible())
}

/// The discrete level at a distance, each for a fifth of it.
fn discrete_lod(collapses: &CollapseSequence, distance: f64) -> Lod {
    let level = ((distance * LEVELS as f64) as usize).min(LEVELS - 1);
    Discrete::lod(collapses, level)
}

/// Chooses the LOD of an object at a distance from 0 to 1.
type Policy = fn(&CollapseSequence, f64) -> Lod;

/// The levels of everyone in a frame by a policy.
fn lods(inputs: &[Input], positions: &[WalkerPosition], policy: Policy) -> Vec<Vec<Lod>> {
    let lods_of = |(i, walker): (usize, &WalkerPosition)| {
        let objects = inputs[i % inputs.len()].objects.iter();
        objects.map(|o| policy(o.object.simplified.collapses(), walker.remoteness)).collect()
    };
    positions.iter().enumerate().map(lods_of).collect()
}

/// The levels of everyone in all frames by a policy.
fn levels(inputs: &[Input], positions: &[Vec<WalkerPosition>], policy: Policy) -> CrowdLevels {
    let lods: Vec<Vec<Vec<Lod>>> = positions.iter().map(|all| lods(inputs, all, policy)).collect();
    let (mut triangles, mut shared, mut changed) = (Vec::new(), 0, 0);
    for pair in lods.windows(2) {
        let mut seen: BTreeMap<(usize, &[Lod]), u64> = BTreeMap::new();
        let mut drawn = 0;
        for (i, (before, now)) in pair[0].iter().zip(&pair[1]).enumerate() {
            let input = i % inputs.len();
            let objects = inputs[input].objects.iter().zip(now);
            drawn += objects
                .map(|(o, &lod)| u64::from(o.object.simplified.collapses().triangles_at(lod)))
                .sum::<u64>();
            changed += u64::from(before != now);
            *seen.entry((input, now)).or_default() += 1;
        }
        triangles.push(drawn as f64);
        shared += seen.values().filter(|&&n| n > 1).sum::<u64>();
    }
    let all = (triangles.len() * positions[0].len()) as f64;
    let frames = Frames {
        triangles_per_frame: triangles.iter().sum::<f64>() / triangles.len() as f64,
        extraction_ms_per_frame: None,
        extraction_spread: None,
        extraction_ms_curve: None,
        shared: shared as f64 / all,
        changed: changed as f64 / all,
    };
    CrowdLevels { lods, triangles, frames }
}

/// Milliseconds, by frame, of moving every cursor of a structure to the level of its instance.
fn extraction(
    name: &str,
    inputs: &[Input],
    baselines: &[Vec<Vec<Baseline>>],
    levels: &CrowdLevels,
) -> Vec<f64> {
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
    // Moves to the levels of the start are not timed.
    move_all(&levels.lods[0]);
    levels.lods[1..].iter().map(|frame| move_all(frame)).collect()
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

/// The figures of a crowd as people read them.
#[must_use]
pub fn crowd_table(report: &CrowdReport) -> String {
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
        let spread = frames.extraction_spread.map(|spread| {
            let deviation = spread.deviation.map_or(String::new(), |d| format!(" ± {d:.3}"));
            format!("  mean {:.3}{deviation}", spread.mean)
        });
        let spread = spread.unwrap_or_default();
        let triangles = grouped(frames.triangles_per_frame.round() as u64);
        // Writing to a string cannot fail.
        let shared = frames.shared * 100.0;
        let _ = writeln!(text, "{name:<18} {triangles:>14} {ms:>12} {shared:>6.1} %{spread}");
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
