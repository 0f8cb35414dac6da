//! The errors that a sequence states, against distances that are measured here at a few levels.

use crate::distance::{Sampling, farther_than};
use crate::surface::Surface;
use lodc_mesh::{CollapseSequence, Lod, PositionIds, Simplified, SplitMix64, is_degenerate};
use lodc_nearest::{Search, TriangleTree};
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
    diagonal: f64,
    /// Distances that are none: rounding errors of coordinates are no differences.
    slack: f64,
    /// Errors that are not worth a refusal if they are too large.
    tiny: f64,
}

impl<'a> Levels<'a> {
    fn new(simplified: &'a Simplified, shape: &'a [[f32; 3]]) -> Self {
        let input = surface(shape, simplified.mesh().triangles().to_vec());
        let diagonal = input.diagonal();
        Self {
            simplified,
            shape,
            positions: PositionIds::new(simplified.mesh().positions()),
            diagonal,
            input: input.tree(),
            slack: 1e-9 * diagonal,
            tiny: 1e-6 * diagonal,
        }
    }

    /// Returns what is wrong with the errors that a level states.
    fn check(&self, lod: Lod) -> Option<String> {
        let collapses = self.simplified.collapses();
        let stored = collapses.error_at(lod);
        let error = f64::from(stored);
        let third = error / OVERSTATED;
        match self.changes(lod).farther_than(third) {
            Some(largest) if largest > TOLERANCE * error + self.slack => {
                return Some(format!("the error is {stored}, measured are {largest}"));
            }
            Some(_) => return None,
            None if error <= self.tiny => return None,
            None => {}
        }
        // Errors never fall: a finer level may be the one that is that far. Samples may miss a
        // small part, so only a bound tells that there is none.
        let rose = collapses.parts().step_errors.partition_point(|&e| e < stored);
        let bound = self.changes(collapses.step(rose).lod).bound(Search::within(self.diagonal));
        (bound < third).then(|| format!("the error is {stored}, no point is farther than {bound}"))
    }

    /// What a level changes. Triangles that it has in common with the input are nowhere apart, so
    /// only the others are measured.
    fn changes(&self, lod: Lod) -> Changes<'_> {
        let Self { simplified, shape, positions, .. } = self;
        let is_changed = |t: &[u32; 3]| t.iter().any(|&v| v < lod.0);
        let map = simplified.collapses().resolve_all(lod);
        let resolved = |t: [u32; 3]| t.map(|v| map[v as usize]);
        let is_live = |t: &[u32; 3]| !is_degenerate(t.map(|v| positions.of_vertex[v as usize]));
        let all = simplified.mesh().triangles();
        let changed: Vec<[u32; 3]> = all.iter().copied().filter(is_changed).collect();
        let result = changed.iter().copied().map(resolved).filter(is_live).collect();
        let shown = simplified.triangles_at_with(lod, positions);
        let shown = shown.iter().map(|t| t.corners).collect();
        Changes {
            input: &self.input,
            level: surface(shape, shown).tree(),
            before: surface(shape, changed),
            after: surface(shape, result),
        }
    }
}

/// What a level changes.
struct Changes<'a> {
    /// All triangles of the input, and of the level.
    input: &'a TriangleTree,
    level: TriangleTree,
    /// Those of the input that the level has not, and those of the level that the input has not.
    before: Surface,
    after: Surface,
}

impl Changes<'_> {
    /// Returns the largest distance that samples find, either way, if it is more than `bound`.
    fn farther_than(&self, bound: f64) -> Option<f64> {
        let (there, back) = rayon::join(
            || farther_than(&self.before, &self.level, bound, &SAMPLING),
            || farther_than(&self.after, self.input, bound, &SAMPLING),
        );
        there.into_iter().chain(back).max_by(f64::total_cmp)
    }

    /// An upper bound of the distance, either way.
    fn bound(&self, search: Search) -> f64 {
        let most = |from: &Surface, to: &TriangleTree| {
            let corners: Vec<_> = (0..from.triangles.len()).map(|t| from.corners(t)).collect();
            search.farthest(&corners, to).most
        };
        let (there, back) =
            rayon::join(|| most(&self.before, &self.level), || most(&self.after, self.input));
        there.max(back)
    }
}

fn surface(shape: &[[f32; 3]], triangles: Vec<[u32; 3]>) -> Surface {
    let positions = shape.iter().map(|&p| p.into()).collect();
    Surface { positions, triangles, ..Surface::default() }
}
