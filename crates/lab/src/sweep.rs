//! Times, bus traffic and drawn indices of linear sweeps over all LODs, towards the coarse end and
//! back (thesis 3.5.2).

use crate::baseline::Rebuild;
use crate::structures::Runner;
use crate::timings::Timings;
use lodc_mesh::{CollapseSequence, Lod, Simplified};
use std::hint::black_box;
use std::ops::Range;
use std::time::Instant;

/// A measurement of less time than this, in microseconds, is repeated until it has taken more:
/// clocks and interruptions would blur it. Chosen by hand.
const MIN_MICROS: f64 = 10_000.0;
/// Jumps of each round, of large meshes one; each is timed by itself. Chosen by hand.
const JUMPS: u32 = 5;
/// Triangles of a mesh times jumps of a round. Chosen by hand.
const MAX_TRIANGLES_OF_JUMPS: usize = 2_000_000;

/// The most points of a curve over LODs. Chosen by hand.
const POINTS: usize = 100;

/// Divides `samples` samples into a range for each point of a curve, which is at the last of its
/// range.
fn parts(samples: usize) -> Vec<Range<usize>> {
    let count = samples.min(POINTS);
    (0..count).map(|i| i * samples / count..(i + 1) * samples / count).collect()
}

/// The points of a curve, from the values at all stops of a sweep: at equal intervals, the last one
/// included.
pub(crate) fn points<T: Copy>(values_at_stops: &[T]) -> Vec<T> {
    let last_of = |part: Range<usize>| values_at_stops[part.end - 1];
    parts(values_at_stops.len()).into_iter().map(last_of).collect()
}

/// The points of a curve: the mean of the values of each of its ranges.
pub(crate) fn means(values: &[f64]) -> Vec<f64> {
    let mean = |run: &[f64]| run.iter().sum::<f64>() / run.len() as f64;
    parts(values.len()).into_iter().map(|part| mean(&values[part])).collect()
}

/// Returns the stops of a sweep on its way down: every `share` of the LODs, the last one included,
/// LOD 0 not.
pub(crate) fn stops(collapses: &CollapseSequence, share: f64) -> Vec<Lod> {
    let records = f64::from(collapses.records());
    let count = (1.0 / share).round().clamp(1.0, 1e6);
    let mut stops: Vec<Lod> =
        (1..=count as u64).map(|i| Lod((records * i as f64 / count).round() as u32)).collect();
    stops.dedup();
    stops.retain(|&lod| lod > Lod(0));
    stops
}

/// The traffic of a sweep and the indices that its LODs draw; the same in every run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Counts {
    /// Bytes sent in all, down and up.
    pub(crate) bytes: u64,
    /// Bytes sent in all if each rewritten index is sent by itself, in four bytes, where those are
    /// fewer. Of no use for runners that rewrite vertices.
    pub(crate) one_by_one: u64,
    /// Indices or vertices rewritten in all, down and up.
    pub(crate) rewritten: u64,
    /// Indices drawn at each stop on the way down.
    pub(crate) drawn: Vec<u64>,
}

/// Counts over one sweep. The cursor is at LOD 0 before and after.
pub(crate) fn counts(runner: &mut dyn Runner, stops: &[Lod]) -> Counts {
    let mut counts = Counts::default();
    let mut seek = |lod: Lod, is_way_down: bool| {
        let (traffic, bytes) = runner.send(lod);
        counts.bytes += bytes;
        counts.one_by_one += bytes.min(4 * traffic.rewritten);
        counts.rewritten += traffic.rewritten;
        counts.drawn.extend(is_way_down.then(|| runner.drawn()));
    };
    stops.iter().for_each(|&lod| seek(lod, true));
    stops_back(stops).for_each(|lod| seek(lod, false));
    counts
}

/// The stops on the way up again, to LOD 0.
fn stops_back(stops: &[Lod]) -> impl Iterator<Item = Lod> {
    stops.iter().rev().skip(1).copied().chain([Lod(0)])
}

/// Times of one runner in microseconds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Times {
    /// A move to a coarser LOD, by rounds.
    pub(crate) coarser: Timings,
    /// A move to a finer LOD, by rounds.
    pub(crate) finer: Timings,
    /// One jump from LOD 0 to the far LOD, each by itself.
    pub(crate) jump: Timings,
    /// A move, both ways, at each point of the curve over LODs, in its best round.
    pub(crate) curve: Vec<f64>,
}

impl Times {
    /// Mean of a move to a coarser and one to a finer LOD, each of its best round.
    pub(crate) fn both_ways(&self) -> f64 {
        f64::midpoint(self.coarser.best(), self.finer.best())
    }
}

/// Times all runners in turn, round after round, so that a busy machine is busy for each of them.
/// Also the time to make the far LOD's index list from scratch.
pub(crate) fn times(
    runners: &mut [&mut Box<dyn Runner + '_>],
    simplified: &Simplified,
    stops: &[Lod],
    far: Lod,
    rounds: u32,
) -> (Vec<Times>, Timings) {
    let mut all = vec![Times::default(); runners.len()];
    let mut rebuild = Rebuild::new(simplified);
    let mut rebuild_micros = Timings::default();
    let most = MAX_TRIANGLES_OF_JUMPS / simplified.mesh().triangles().len().max(1);
    let jumps = (most as u32).clamp(1, JUMPS);
    for _ in 0..rounds {
        for (runner, times) in runners.iter_mut().zip(&mut all) {
            let sweeps = sweeps(runner.as_mut(), stops);
            times.coarser.add(sweeps.down);
            times.finer.add(sweeps.up);
            times.curve.resize(sweeps.curve.len(), f64::INFINITY);
            times.curve.iter_mut().zip(sweeps.curve).for_each(|(best, t)| *best = best.min(t));
        }
    }
    // After the sweeps: a jump leaves work for later moves of some runners.
    for _ in 0..rounds {
        for (runner, times) in runners.iter_mut().zip(&mut all) {
            for _ in 0..jumps {
                times.jump.add(micros(|| runner.seek(far)));
                runner.seek(Lod(0));
            }
        }
        for _ in 0..jumps {
            rebuild_micros.add(micros(|| rebuild.indices_at(far).len()));
        }
    }
    (all, rebuild_micros)
}

/// Mean microseconds of a move.
struct Sweeps {
    down: f64,
    up: f64,
    /// Both ways, at each point of a curve.
    curve: Vec<f64>,
}

/// Times as many sweeps as it takes to measure them.
fn sweeps(runner: &mut dyn Runner, stops: &[Lod]) -> Sweeps {
    let parts = parts(stops.len());
    let mut curve = vec![0.0; parts.len()];
    let (mut down, mut up, mut sweeps) = (0.0, 0.0, 0.0);
    let way_back: Vec<Lod> = stops_back(stops).collect();
    while down < MIN_MICROS || up < MIN_MICROS {
        let mut time_part = |lods: &[Lod], sum: &mut f64, point: &mut f64| {
            let time = micros(|| lods.iter().map(|&lod| runner.seek(lod).rewritten).sum::<u64>());
            *sum += time;
            *point += time;
        };
        for (range, point) in parts.iter().zip(&mut curve) {
            time_part(&stops[range.clone()], &mut down, point);
        }
        // The way back leaves the stops of a part in the opposite order.
        for (range, point) in parts.iter().zip(&mut curve).rev() {
            let range = stops.len() - range.end..stops.len() - range.start;
            time_part(&way_back[range], &mut up, point);
        }
        sweeps += 1.0;
    }
    let updates = sweeps * stops.len() as f64;
    let means = parts.iter().zip(curve).map(|(p, t)| t / (2.0 * sweeps * p.len() as f64));
    Sweeps { down: down / updates, up: up / updates, curve: means.collect() }
}

fn micros<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    black_box(work());
    start.elapsed().as_secs_f64() * 1e6
}
