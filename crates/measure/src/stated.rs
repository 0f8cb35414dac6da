//! The errors that a sequence states, against distances that are measured here at a few levels.

use crate::distance::{Sampling, farther_than, mean_square};
use crate::surface::Surface;
use lodc_mesh::{CollapseSequence, Lod, PositionIds, Simplified, SplitMix64, is_degenerate};
use lodc_nearest::{Search, TriangleTree};
use rayon::prelude::*;

/// Levels that are measured, spread over the triangle counts.
const LEVELS: u32 = 8;

/// Chooses the levels.
const SEED: u64 = 0x6572_726f_7273;

/// Fewer samples than [`Sampling::DEFAULT`], and on small surfaces about one and the corners and
/// middles of edges for a triangle: what samples find nearly too far is looked at closely.
fn sampling(triangles: usize) -> Sampling {
    Sampling {
        samples: triangles.clamp(1_000, 20_000),
        lattice: (6 * triangles).min(30_000),
        seed: 0x5eed,
    }
}

/// Measured distances may be this many times the stored ones, which know samples only.
const TOLERANCE: f64 = 1.05;

/// Stored distances may be this many times the measured ones.
const OVERSTATED: f64 = 3.0;

/// Measured root mean square distances may be this many times the stored ones. Both are means of
/// samples.
const RMS_TOLERANCE: f64 = 1.9;

/// Means below this share of the error are those of a hundredth of the surface, which the writer's
/// samples may have missed: they are not refused for being stated too small.
const RMS_OF_PARTS: f64 = 0.125;

/// Stored ones may be this many times the measured ones: samples that travel stop where they are
/// near enough.
const RMS_OVERSTATED: f64 = 8.0;

/// Samples of a root mean square distance: at first, and before it is refused.
const RMS_SAMPLES: [u32; 2] = [2_000, 20_000];

/// Number of neighbouring slices of equal area that may have been sampled where they are unusually
/// near, or far: 3 of `n` that all miss a part have a chance of 5 % if that part is 3/n of the
/// area.
const MISSED_SLICES: f64 = 3.0;

/// Compares the errors and root mean square distances of a sequence with measured ones: returns how
/// many levels were measured, and what is wrong with the first whose error does not hold. `shapes`
/// are the surfaces that the errors are the maximum over, each with a place for every vertex: the
/// one at rest first.
#[must_use]
pub fn check_errors<S: AsRef<[[f32; 3]]> + Sync>(
    simplified: &Simplified,
    shapes: &[S],
) -> (usize, Option<String>) {
    let lods = levels(simplified.collapses());
    let shapes: Vec<&[[f32; 3]]> = shapes.iter().map(AsRef::as_ref).collect();
    (lods.len(), first_difference(simplified, &shapes, &lods))
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
fn first_difference(
    simplified: &Simplified,
    shapes: &[&[[f32; 3]]],
    lods: &[Lod],
) -> Option<String> {
    let levels = Levels::new(simplified, shapes);
    let check = |&lod: &Lod| Some(format!("LOD {}: {}", lod.0, levels.check(lod)?));
    let wrong: Vec<Option<String>> = lods.par_iter().with_max_len(1).map(check).collect();
    wrong.into_iter().flatten().next()
}

/// The levels of a sequence, ready to be measured.
struct Levels<'a> {
    simplified: &'a Simplified,
    positions: PositionIds,
    /// The first of the triangles that lie on each other, at every level.
    distinct: Vec<[u32; 3]>,
    shapes: Vec<Shape<'a>>,
}

/// The input in one shape.
struct Shape<'a> {
    places: &'a [[f32; 3]],
    /// Vertices at one position are at one place, so that triangles on each other stay there.
    is_whole: bool,
    input: TriangleTree,
    diagonal: f64,
    /// Twice the area.
    area: f64,
}

impl Shape<'_> {
    /// Distances that are none: singles as long as the diagonal are rounded to about as much.
    fn slack(&self) -> f64 {
        1e-7 * self.diagonal
    }

    /// Errors that are not worth a refusal if they are too large.
    fn tiny(&self) -> f64 {
        1e-6 * self.diagonal
    }
}

impl<'a> Levels<'a> {
    fn new(simplified: &'a Simplified, shapes: &[&'a [[f32; 3]]]) -> Self {
        let positions = PositionIds::new(simplified.mesh().positions());
        let all = simplified.mesh().triangles();
        let distinct = distinct(all, &positions);
        let shape = |&places: &&'a [[f32; 3]]| {
            let first = |v: usize| positions.first_vertex[positions.of_vertex[v] as usize];
            let is_whole = (0..places.len()).all(|v| places[v] == places[first(v) as usize]);
            let input = surface(places, if is_whole { distinct.clone() } else { all.to_vec() });
            let area = area(&input);
            Shape { places, is_whole, diagonal: input.diagonal(), input: input.tree(), area }
        };
        let shapes = shapes.par_iter().map(shape).collect();
        Self { simplified, positions, distinct, shapes }
    }

    /// Returns what is wrong with the distances that a level states.
    fn check(&self, lod: Lod) -> Option<String> {
        let changes = self.changes(lod);
        self.check_error(lod, &changes).or_else(|| self.check_rms(lod, &changes))
    }

    /// Returns what is wrong with the root mean square distance that a level states: it is looked
    /// at with more samples before it is refused.
    fn check_rms(&self, lod: Lod, changes: &[Changes<'_>]) -> Option<String> {
        let collapses = self.simplified.collapses();
        let stored = collapses.rms_at(lod)?;
        let (rms, error) = (f64::from(stored), f64::from(collapses.error_at(lod)));
        let slack = self.shapes.iter().map(Shape::slack).fold(0.0, f64::max);
        let tiny = self.shapes.iter().map(Shape::tiny).fold(0.0, f64::max);
        let mut measured = 0.0;
        for samples in RMS_SAMPLES {
            // No point is farther than the error, so what samples miss cannot matter more.
            let missed = MISSED_SLICES / f64::from(samples) * error * error;
            let square = mean_square_of(changes, samples);
            let least = (square - missed).max(0.0).sqrt();
            let too_small = least > (RMS_TOLERANCE * rms).max(RMS_OF_PARTS * error) + slack;
            let most = || {
                // It never falls: a finer level may be the one that is that far.
                let rose = collapses.parts().step_rms.partition_point(|&r| r < stored);
                let finer = self.changes(collapses.step(rose).lod);
                (square.max(mean_square_of(&finer, samples)) + missed).sqrt()
            };
            let is_tiny = rms <= tiny || rms <= RMS_OVERSTATED * (square + missed).sqrt();
            if !too_small && (is_tiny || rms <= RMS_OVERSTATED * most()) {
                return None;
            }
            measured = square.sqrt();
        }
        Some(format!("the root mean square distance is {stored}, measured are {measured}"))
    }

    /// Returns what is wrong with the errors that a level states. One shape that is far enough says
    /// that they are not too large; of the others, only what is too far is looked for.
    fn check_error(&self, lod: Lod, changes: &[Changes<'_>]) -> Option<String> {
        let collapses = self.simplified.collapses();
        let stored = collapses.error_at(lod);
        let error = f64::from(stored);
        let third = error / OVERSTATED;
        let mut holds = error <= self.shapes.iter().map(Shape::tiny).fold(0.0, f64::max);
        for (number, shape) in self.shapes.iter().enumerate() {
            let most = TOLERANCE * error + shape.slack();
            let found = changes[number].farther_than(if holds { most } else { third });
            match found {
                Some(largest) if largest > most => {
                    let pose =
                        if number > 0 { format!(" in pose {number}") } else { String::new() };
                    let what = format!("the error is {stored}, measured are {largest}{pose}");
                    return Some(what);
                }
                found => holds |= found.is_some(),
            }
        }
        if holds {
            return None;
        }
        // Errors never fall: a finer level may be the one that is that far. Samples may miss a
        // small part, so only a bound tells that there is none.
        let rose = collapses.parts().step_errors.partition_point(|&e| e < stored);
        let finer = self.changes(collapses.step(rose).lod);
        let search = |shape: &Shape| Search::within(shape.diagonal);
        let bounds = finer.iter().zip(&self.shapes).map(|(c, shape)| c.bound(search(shape)));
        let bound = bounds.fold(0.0, f64::max);
        (bound < third).then(|| format!("the error is {stored}, no point is farther than {bound}"))
    }

    /// What a level changes in each shape. Triangles that it has in common with the input are
    /// nowhere apart, so only the others are measured.
    fn changes(&self, lod: Lod) -> Vec<Changes<'_>> {
        let Self { simplified, positions, .. } = self;
        let is_changed = |t: &[u32; 3]| t.iter().any(|&v| v < lod.0);
        let map = simplified.collapses().resolve_all(lod);
        let resolved = |t: [u32; 3]| t.map(|v| map[v as usize]);
        let is_live = |t: &[u32; 3]| !is_degenerate(t.map(|v| positions.of_vertex[v as usize]));
        let shown = simplified.triangles_at_with(lod, positions);
        let shown: Vec<[u32; 3]> = shown.iter().map(|t| t.corners).collect();
        let mut changes = Vec::with_capacity(self.shapes.len());
        for shape in &self.shapes {
            let all = if shape.is_whole { &self.distinct } else { simplified.mesh().triangles() };
            let (before, same): (Vec<_>, Vec<_>) = all.iter().partition(|t| is_changed(t));
            let after = before.iter().copied().map(resolved).filter(is_live).collect();
            let [level, before, after, same] = [shown.clone(), before, after, same]
                .map(|triangles| surface(shape.places, triangles));
            let areas = [shape.area, area(&same) + area(&after)];
            let level = level.tree();
            changes.push(Changes { input: &shape.input, level, before, after, areas });
        }
        changes
    }
}

/// The mean squared distance of a level, the largest over ways and shapes.
fn mean_square_of(changes: &[Changes<'_>], samples: u32) -> f64 {
    changes.iter().map(|change| change.mean_square(samples as usize)).fold(0.0, f64::max)
}

/// What a level changes.
struct Changes<'a> {
    /// All triangles of the input, and of the level.
    input: &'a TriangleTree,
    level: TriangleTree,
    /// Those of the input that the level has not, and those of the level that the input has not.
    before: Surface,
    after: Surface,
    /// Twice the areas of the whole input and of the whole level; faces on each other count once.
    areas: [f64; 2],
}

impl Changes<'_> {
    /// Returns the largest distance that samples find, either way, if it is more than `bound`.
    fn farther_than(&self, bound: f64) -> Option<f64> {
        let way = |from: &Surface, to: &TriangleTree| {
            farther_than(from, to, bound, &sampling(from.triangles.len()))
        };
        let (there, back) =
            rayon::join(|| way(&self.before, &self.level), || way(&self.after, self.input));
        there.into_iter().chain(back).max_by(f64::total_cmp)
    }

    /// The mean squared distance over the whole area, the larger of both ways. What is the same on
    /// both sides adds area alone.
    fn mean_square(&self, samples: usize) -> f64 {
        let way = |changed: &Surface, to: &TriangleTree, all: f64| {
            let share = area(changed) / all;
            if share > 0.0 { share * mean_square(changed, to, samples, SEED) } else { 0.0 }
        };
        let (there, back) = rayon::join(
            || way(&self.before, &self.level, self.areas[0]),
            || way(&self.after, self.input, self.areas[1]),
        );
        there.max(back)
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

/// The first of each set of triangles whose positions are the same, in any order.
fn distinct(triangles: &[[u32; 3]], positions: &PositionIds) -> Vec<[u32; 3]> {
    let mut order: Vec<([u32; 3], u32)> = (0..)
        .zip(triangles)
        .map(|(number, t)| {
            let mut ids = t.map(|v| positions.of_vertex[v as usize]);
            ids.sort_unstable();
            (ids, number)
        })
        .collect();
    order.sort_unstable();
    order.dedup_by_key(|(ids, _)| *ids);
    order.sort_unstable_by_key(|&(_, number)| number);
    order.into_iter().map(|(_, number)| triangles[number as usize]).collect()
}

/// Twice the area of a surface.
fn area(surface: &Surface) -> f64 {
    let twice = |t| {
        let [a, b, c] = surface.corners(t);
        (b - a).cross(c - a).length()
    };
    (0..surface.triangles.len()).map(twice).sum()
}

fn surface(shape: &[[f32; 3]], triangles: Vec<[u32; 3]>) -> Surface {
    let positions = shape.iter().map(|&p| p.into()).collect();
    Surface { positions, triangles, ..Surface::default() }
}
