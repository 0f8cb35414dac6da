//! Times of moves, and what they send and draw: linear sweeps over all LODs, down and up
//! (thesis 3.5.2).

use super::subject::Runner;
use lodc_baseline::Rebuild;
use lodc_mesh::{CollapseSequence, Lod, Simplified};
use std::hint::black_box;
use std::time::Instant;

/// A measurement shorter than this is repeated until it is not: clocks and interruptions would blur
/// it.
const SHORTEST: f64 = 0.01;
/// Jumps of each round; each is timed by itself.
const JUMPS: u32 = 5;

/// Returns the stops of a sweep on its way down: every `share` of the LODs, the last one included,
/// LOD 0 not.
pub(super) fn stops(collapses: &CollapseSequence, share: f64) -> Vec<Lod> {
    let records = f64::from(collapses.records());
    let count = (1.0 / share).round().clamp(1.0, 1e6);
    let mut stops: Vec<Lod> =
        (1..=count as u64).map(|i| Lod((records * i as f64 / count).round() as u32)).collect();
    stops.dedup();
    stops.retain(|&lod| lod > Lod(0));
    stops
}

/// The traffic of a sweep and the indices that its LODs draw; the same in every run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts {
    /// Bytes sent in all, down and up.
    pub(super) bytes: u64,
    /// Indices or vertices rewritten in all, down and up.
    pub(super) rewritten: u64,
    /// Indices drawn at all stops together.
    pub(super) drawn: u64,
}

/// Counts over one sweep. The cursor is at LOD 0 before and after.
pub(super) fn counts(runner: &mut dyn Runner, stops: &[Lod]) -> Counts {
    let mut counts = Counts::default();
    let mut seek = |lod: Lod, draw: bool| {
        let (traffic, bytes) = runner.send(lod);
        counts.bytes += bytes;
        counts.rewritten += traffic.rewritten;
        counts.drawn += if draw { runner.drawn() } else { 0 };
    };
    stops.iter().for_each(|&lod| seek(lod, true));
    back(stops).for_each(|lod| seek(lod, false));
    counts
}

/// The way up again, to LOD 0.
fn back(stops: &[Lod]) -> impl Iterator<Item = Lod> {
    stops.iter().rev().skip(1).copied().chain([Lod(0)])
}

/// Microseconds, the best of all rounds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    /// Mean of the moves to coarser LODs.
    pub(super) coarser: f64,
    /// Mean of the moves to finer LODs.
    pub(super) finer: f64,
    /// One jump from LOD 0 to the far LOD.
    pub(super) jump: f64,
}

impl Times {
    /// Mean of all moves, both ways.
    pub(super) fn mean(&self) -> f64 {
        f64::midpoint(self.coarser, self.finer)
    }
}

/// Times everybody in turn, round after round, so that a busy machine is busy for all of them. Also
/// what it takes to make the far LOD's index list from scratch.
pub(super) fn times(
    runners: &mut [&mut Box<dyn Runner + '_>],
    simplified: &Simplified,
    stops: &[Lod],
    far: Lod,
    rounds: u32,
) -> (Vec<Times>, f64) {
    let never = Times { coarser: f64::INFINITY, finer: f64::INFINITY, jump: f64::INFINITY };
    let mut best = vec![never; runners.len()];
    let mut rebuild = Rebuild::new(simplified);
    let mut scratch = f64::INFINITY;
    for _ in 0..rounds {
        for (runner, best) in runners.iter_mut().zip(&mut best) {
            let (coarser, finer) = sweeps(runner.as_mut(), stops);
            best.coarser = best.coarser.min(coarser);
            best.finer = best.finer.min(finer);
        }
    }
    // After the sweeps: a jump leaves work for later moves of some models.
    for _ in 0..rounds {
        for (runner, best) in runners.iter_mut().zip(&mut best) {
            for _ in 0..JUMPS {
                best.jump = best.jump.min(micros(|| runner.seek(far)));
                runner.seek(Lod(0));
            }
        }
        for _ in 0..JUMPS {
            scratch = scratch.min(micros(|| rebuild.at(far).len()));
        }
    }
    (best, scratch)
}

/// Mean microseconds of a move down and of one up, over as many sweeps as it takes to measure them.
fn sweeps(runner: &mut dyn Runner, stops: &[Lod]) -> (f64, f64) {
    let (mut down, mut up, mut sweeps) = (0.0, 0.0, 0.0);
    while down < SHORTEST * 1e6 || up < SHORTEST * 1e6 {
        down += micros(|| stops.iter().map(|&lod| runner.seek(lod).rewritten).sum::<u64>());
        up += micros(|| back(stops).map(|lod| runner.seek(lod).rewritten).sum::<u64>());
        sweeps += stops.len() as f64;
    }
    (down / sweeps, up / sweeps)
}

fn micros<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    black_box(work());
    start.elapsed().as_secs_f64() * 1e6
}
