//! The errors that a sequence states, against distances that are measured here at a few levels.

use crate::distance::{Sampling, farther_than, mean_square};
use crate::surface::Surface;
use lodc_mesh::{CollapseSequence, Lod, PositionIds, Simplified, SplitMix64, is_degenerate};
use lodc_nearest::TriangleTree;
use rayon::prelude::*;

/// Levels that are measured, spread over the triangle counts.
const LEVELS: u32 = 8;

/// Chooses the levels.
const SEED: u64 = 0x6572_726f_7273;

/// Fewer samples than [`Sampling::DEFAULT`]: a stored error that is half of the true one is found
/// all the same.
const SAMPLING: Sampling = Sampling { samples: 20_000, lattice: 30_000, seed: 0x5eed };

/// Measured distances may be so much larger than the stored ones, which know samples only.
const TOLERANCE: f64 = 1.05;

/// Stored distances may be so many times the measured ones.
const OVERSTATED: f64 = 3.0;

/// Root mean square distances are estimates that follow few samples: on slivers they were up to
/// five times too large or too small, elsewhere within a third.
const ESTIMATED: f64 = 5.0;

/// Compares the errors of a sequence with measured ones: returns how many levels were measured, and
/// what is wrong with the first whose error does not hold. `shape` is the surface that the scene
/// shows, a place for each vertex.
#[must_use]
pub fn check_errors(simplified: &Simplified, shape: &[[f32; 3]]) -> (usize, Option<String>) {
    let lods = levels(simplified.collapses());
    (lods.len(), first_difference(simplified, shape, &lods))
}

/// Returns levels with triangles, one by chance from each of some ranges of triangle counts.
fn levels(collapses: &CollapseSequence) -> Vec<Lod> {
    let mut random = SplitMix64::new(SEED);
    let mut above = f64::from(collapses.parts().triangles);
    let ratio = above.powf(1.0 / f64::from(LEVELS));
    let mut lods = Vec::new();
    for _ in 0..LEVELS {
        let below = above / ratio;
        let wanted = below + (above - below) * f64::from(random.unit());
        lods.push(collapses.lod_for_triangles(wanted as u32).min(collapses.last_visible()));
        above = below;
    }
    lods.dedup();
    lods.retain(|&lod| lod > Lod(0));
    lods
}

/// Returns what is wrong with the first level whose errors do not hold.
fn first_difference(simplified: &Simplified, shape: &[[f32; 3]], lods: &[Lod]) -> Option<String> {
    let levels = Levels::new(simplified, shape);
    lods.par_iter()
        .with_max_len(1)
        .find_map_first(|&lod| levels.check(lod).map(|wrong| format!("LOD {}: {wrong}", lod.0)))
}

/// The levels of a sequence, ready to be measured.
struct Levels<'a> {
    simplified: &'a Simplified,
    shape: &'a [[f32; 3]],
    positions: PositionIds,
    input: TriangleTree,
    /// The area of the input.
    area: f64,
    /// Distances that are none: rounding errors of coordinates are no differences.
    slack: f64,
    /// Errors that are not worth a refusal if they are too large.
    tiny: f64,
    /// Likewise root mean square distances, too large or too small.
    seen: f64,
}

/// Distances between the input and a level, the larger of both ways.
struct Measured {
    /// The largest, if it is more than what was asked for.
    largest: Option<f64>,
    rms: f64,
}

impl<'a> Levels<'a> {
    fn new(simplified: &'a Simplified, shape: &'a [[f32; 3]]) -> Self {
        let input = surface(shape, simplified.mesh().triangles().to_vec());
        let diagonal = input.diagonal();
        Self {
            simplified,
            shape,
            positions: PositionIds::new(simplified.mesh().positions()),
            area: area(&input),
            input: input.tree(),
            slack: 1e-9 * diagonal,
            tiny: 1e-6 * diagonal,
            seen: 3e-4 * diagonal,
        }
    }

    /// Returns what is wrong with the errors that a level states.
    fn check(&self, lod: Lod) -> Option<String> {
        let collapses = self.simplified.collapses();
        let stored = collapses.error_at(lod);
        let error = f64::from(stored);
        let Measured { largest, rms } = self.measure(lod, error / OVERSTATED);
        if let Some(largest) = largest.filter(|&most| most > TOLERANCE * error + self.slack) {
            return Some(format!("the error is {stored}, measured are {largest}"));
        }
        // Errors never fall: a finer level may be the one that is that far.
        let rose = |value: f32, at: fn(&CollapseSequence, Lod) -> f32| {
            let steps = (0..collapses.steps_at(lod)).map(|i| collapses.step(i).lod);
            let lods: Vec<Lod> = steps.collect();
            lods[lods.partition_point(|&finer| at(collapses, finer) < value)]
        };
        if largest.is_none() && error > self.tiny {
            let finer = self.measure(rose(stored, CollapseSequence::error_at), error / OVERSTATED);
            if finer.largest.is_none() {
                let third = error / OVERSTATED;
                return Some(format!("the error is {stored}, no point is farther than {third}"));
            }
        }
        let stored = collapses.rms_at(lod)?;
        let stated = f64::from(stored);
        let wrong = || Some(format!("the RMS distance is {stored}, measured are {rms}"));
        if rms > ESTIMATED * stated + self.seen {
            return wrong();
        }
        if stated > ESTIMATED * rms + self.seen {
            let rms_at = |collapses: &CollapseSequence, lod| collapses.rms_at(lod).unwrap_or(0.0);
            let finer = self.measure(rose(stored, rms_at), f64::INFINITY);
            if stated > ESTIMATED * finer.rms + self.seen {
                return wrong();
            }
        }
        None
    }

    /// Measures a level. Triangles that it has in common with the input are nowhere apart, so
    /// samples lie on the others. `bound` is what the largest distance has to exceed to be told.
    fn measure(&self, lod: Lod, bound: f64) -> Measured {
        let Self { simplified, shape, positions, .. } = self;
        let is_changed = |t: &[u32; 3]| t.iter().any(|&v| v < lod.0);
        let map = simplified.collapses().resolve_all(lod);
        let resolved = |t: [u32; 3]| t.map(|v| map[v as usize]);
        let is_live = |t: &[u32; 3]| !is_degenerate(t.map(|v| positions.of_vertex[v as usize]));
        let all = simplified.mesh().triangles();
        let changed: Vec<[u32; 3]> = all.iter().copied().filter(is_changed).collect();
        let result = changed.iter().copied().map(resolved).filter(is_live).collect();
        let [changed, result] = [changed, result].map(|triangles| surface(shape, triangles));
        let [area_there, area_back] = [&changed, &result].map(area);
        let kept = (self.area - area_there).max(0.0);
        // The mean is over the whole surface.
        let rms = |surface: &Surface, to: &TriangleTree, own: f64| match kept + own {
            all if all > 0.0 => mean_square(surface, to, &SAMPLING) * own / all,
            _ => 0.0,
        };
        let one_way = |from: &Surface, to: &TriangleTree, own: f64| {
            let largest =
                if bound.is_finite() { farther_than(from, to, bound, &SAMPLING) } else { None };
            (largest, rms(from, to, own))
        };
        let back = || one_way(&result, &self.input, area_back);
        let there = || {
            let shown = simplified.triangles_at_with(lod, positions);
            let shown = shown.iter().map(|t| t.corners).collect();
            let tree = surface(shape, shown).tree();
            one_way(&changed, &tree, area_there)
        };
        let (there, back) = rayon::join(there, back);
        let largest = there.0.into_iter().chain(back.0).max_by(f64::total_cmp);
        Measured { largest, rms: there.1.max(back.1).sqrt() }
    }
}

fn area(surface: &Surface) -> f64 {
    (0..surface.triangles.len()).map(|t| lodc_nearest::area(surface.corners(t))).sum()
}

fn surface(shape: &[[f32; 3]], triangles: Vec<[u32; 3]>) -> Surface {
    let positions = shape.iter().map(|&p| p.into()).collect();
    Surface { positions, triangles, ..Surface::default() }
}
