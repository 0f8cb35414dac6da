//! The LODs (levels of detail) at which a device is compared with the CPU: both ends, evenly spread
//! steps going coarser and finer, and random jumps; and the linear sweep that is timed.

use lodc_mesh::{CollapseSequence, Lod, Simplified, SplitMix64};

/// Triangles that all comparisons together look at, about: some seconds for a software adapter.
/// Chosen by hand.
const MAX_TRIANGLES: usize = 40_000_000;

/// The schedule of a verification: every 0.1 % of the steps down and up and a hundred jumps, fewer
/// (but at least 16 each) on large meshes.
#[must_use]
pub fn stops(simplified: &Simplified) -> Vec<Lod> {
    let max_stops = (MAX_TRIANGLES / simplified.mesh().triangles().len().max(1)).max(16) as u32;
    schedule(simplified.collapses(), max_stops.min(1000), max_stops.min(100), 1)
}

/// The LODs at which whole states are compared: LOD 0, some `grid` steps evenly spread going
/// coarser, the last, the same going finer, and `jumps` far jumps (not rounded to steps). All steps
/// if there are not more than `grid`.
#[must_use]
pub fn schedule(collapses: &CollapseSequence, grid: u32, jumps: u32, seed: u64) -> Vec<Lod> {
    let steps = collapses.steps();
    let stride = steps.div_ceil(grid.max(1) as usize).max(1);
    let lod = |step: usize| if step == 0 { Lod(0) } else { collapses.step(step - 1).lod };
    let mut down: Vec<Lod> = (0..steps).step_by(stride).map(lod).collect();
    down.push(lod(steps));
    let up: Vec<Lod> = down.iter().rev().skip(1).copied().collect();
    let mut random = SplitMix64::new(seed);
    let far = (0..jumps).map(|_| Lod((random.bits() >> 32) as u32 % (collapses.records() + 1)));
    down.iter().copied().chain(up).chain(far).collect()
}

/// Updates of a linear sweep to the coarsest LOD in Ripollés's thesis (2009, section 3.5.2: 0.1 %
/// of the records each); then the same number back.
pub const SWEEP_UPDATES: u32 = 1000;

/// Updates of the sweep whose draws are timed, each way. Chosen by hand.
pub const DRAWN_UPDATES: u32 = 10;

/// A linear sweep over all LODs in `updates` updates, coarser and then finer again, LOD 0 at both
/// ends.
#[must_use]
pub fn sweep(collapses: &CollapseSequence, updates: u32) -> Vec<Lod> {
    let lod = |i: u32| (u64::from(collapses.records()) * u64::from(i) / u64::from(updates)) as u32;
    let down: Vec<Lod> = (0..=updates).map(|i| collapses.floor(Lod(lod(i)))).collect();
    down.iter().copied().chain(down.iter().rev().skip(1).copied()).collect()
}
