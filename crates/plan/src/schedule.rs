//! The LODs (levels of detail) at which a device is compared with the CPU: both ends, evenly spread
//! steps going coarser and finer, and random jumps; and the linear sweep that is timed.

use lodc_mesh::{CollapseSequence, Lod, Simplified, SplitMix64};

/// Triangles that all comparisons together look at, about: some seconds for a software adapter.
/// Chosen by hand.
const MAX_TRIANGLES: usize = 40_000_000;

/// Steps at which a verification compares, besides jumps, at most. Chosen by hand: twice as many
/// as the processor's models are compared at in full; on a software adapter more take longer than
/// all checks of the processor together.
const MAX_STEPS: usize = 400;

/// The schedule of a verification: LOD 0, every 0.5 % of the steps going coarser, the last, those
/// half way between them going finer, and a hundred jumps; fewer (but at least 16 in all, and 16
/// jumps) on large meshes.
#[must_use]
pub fn stops(simplified: &Simplified) -> Vec<Lod> {
    let collapses = simplified.collapses();
    let most = (MAX_TRIANGLES / simplified.mesh().triangles().len().max(1)).max(16);
    let (steps, grid) = (collapses.steps(), most.min(MAX_STEPS));
    let stride = steps.div_ceil(grid).max(1);
    let down = (0..steps).step_by(2 * stride).chain([steps]);
    let finer: Vec<usize> = (stride..steps).step_by(2 * stride).collect();
    let there_and_back = down.chain(finer.into_iter().rev()).chain([0]);
    let lods: Vec<Lod> = there_and_back.map(|step| lod_after(collapses, step)).collect();
    [lods, jumps(collapses, most.min(100) as u32, 1)].concat()
}

/// The LODs at which whole states are compared: LOD 0, some `grid` steps evenly spread going
/// coarser, the last, the same going finer, and `jumps` far jumps (not rounded to steps). All steps
/// if there are not more than `grid`.
#[must_use]
pub fn schedule(collapses: &CollapseSequence, grid: u32, jumps: u32, seed: u64) -> Vec<Lod> {
    let steps = collapses.steps();
    let stride = steps.div_ceil(grid.max(1) as usize).max(1);
    let mut down: Vec<Lod> =
        (0..steps).step_by(stride).map(|step| lod_after(collapses, step)).collect();
    down.push(lod_after(collapses, steps));
    let up: Vec<Lod> = down.iter().rev().skip(1).copied().collect();
    [down, up, self::jumps(collapses, jumps, seed)].concat()
}

/// The LOD after `steps` steps.
fn lod_after(collapses: &CollapseSequence, steps: usize) -> Lod {
    if steps == 0 { Lod(0) } else { collapses.step(steps - 1).lod }
}

/// Random LODs, not rounded to steps.
fn jumps(collapses: &CollapseSequence, count: u32, seed: u64) -> Vec<Lod> {
    let mut random = SplitMix64::new(seed);
    let mut far = || Lod((random.bits() >> 32) as u32 % (collapses.records() + 1));
    (0..count).map(|_| far()).collect()
}

/// Updates of a linear sweep to the coarsest LOD in Ripollés's thesis (2009, section 3.5.2: 0.1 %
/// of the records each); then the same number back.
pub const SWEEP_UPDATES: u32 = 1000;

/// Updates of the sweep whose draws are timed, each way, unless a mesh is large. Chosen by hand.
pub const DRAWN_UPDATES: u32 = 10;

/// Vertices that all timed updates of a sweep together have, about: ten seconds for a software
/// adapter. Chosen by hand.
const MAX_UPDATED: usize = 150_000_000;
/// Triangles that all timed draws of a sweep together have, about. Chosen by hand.
const MAX_DRAWN: usize = 40_000_000;
/// The fewest updates that are timed, however large a mesh is. Chosen by hand.
const MIN_UPDATES: usize = 16;

/// The updates of a linear sweep down and up that are timed, as the LODs before and after each: all
/// of [`SWEEP_UPDATES`] each way, or of a large mesh some, evenly spread. The last one ends at
/// LOD 0.
#[must_use]
pub fn timed_updates(simplified: &Simplified) -> Vec<[Lod; 2]> {
    let stops = sweep(simplified.collapses(), SWEEP_UPDATES);
    let all: Vec<[Lod; 2]> = stops.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    spread(&all, simplified.mesh().vertex_count())
}

/// As many of some updates as are timed of a mesh of so many vertices, the last one among them.
fn spread(all: &[[Lod; 2]], vertices: usize) -> Vec<[Lod; 2]> {
    let count = (MAX_UPDATED / vertices.max(1)).clamp(MIN_UPDATES, all.len());
    (1..=count).map(|i| all[i * all.len() / count - 1]).collect()
}

/// The stops of a linear sweep down and up whose draws are timed: fewer of a large mesh.
#[must_use]
pub fn drawn_stops(simplified: &Simplified) -> Vec<Lod> {
    let most = MAX_DRAWN / simplified.mesh().triangles().len().max(1);
    let updates = (most as u32).clamp(2, DRAWN_UPDATES);
    sweep(simplified.collapses(), updates)
}

/// A linear sweep over all LODs in `updates` updates, coarser and then finer again, LOD 0 at both
/// ends.
#[must_use]
pub fn sweep(collapses: &CollapseSequence, updates: u32) -> Vec<Lod> {
    let lod = |i: u32| (u64::from(collapses.records()) * u64::from(i) / u64::from(updates)) as u32;
    let down: Vec<Lod> = (0..=updates).map(|i| collapses.floor(Lod(lod(i)))).collect();
    down.iter().copied().chain(down.iter().rev().skip(1).copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every step of a small mesh is compared, once; both ends are, and jumps follow.
    #[test]
    fn a_verification_stops_at_every_step_of_a_small_mesh() {
        let simplified = lodc_fixtures::random_collapse(&lodc_fixtures::icosphere(2), 1);
        let collapses = simplified.collapses();
        let stops = stops(&simplified);
        let (swept, jumps) = stops.split_at(stops.len() - 100);
        let turn = swept.iter().position(|&lod| lod == collapses.last()).expect("the last LOD");
        assert!(swept[..=turn].is_sorted() && swept[turn..].is_sorted_by(|a, b| a > b));
        let mut sorted = swept.to_vec();
        sorted.sort_unstable();
        let all: Vec<Lod> = (0..=collapses.steps()).map(|s| lod_after(collapses, s)).collect();
        assert_eq!(sorted[1..], all, "LOD 0 is at both ends");
        assert!(jumps.iter().all(|lod| lod.0 <= collapses.records()));
    }

    /// All updates of a small mesh are timed; of a large one some, up to the last.
    #[test]
    fn updates_of_a_large_mesh_are_fewer() {
        let simplified = lodc_fixtures::random_collapse(&lodc_fixtures::icosphere(2), 1);
        let updates = timed_updates(&simplified);
        assert_eq!(updates.len(), 2 * SWEEP_UPDATES as usize);
        assert!(updates.windows(2).all(|pair| pair[0][1] == pair[1][0]));
        for vertices in [100_000, 4_000_000, 400_000_000] {
            let some = spread(&updates, vertices);
            assert_eq!(some.len(), (MAX_UPDATED / vertices).max(MIN_UPDATES));
            assert_eq!((some.last(), some.len() < updates.len()), (updates.last(), true));
        }
    }
}
