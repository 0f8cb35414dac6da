//! Checks the errors that a collapse sequence stores against distances that are measured
//! independently at a few levels, for `lodc verify`.

use crate::distance::{Sampling, farther_than, mean_square};
use crate::surface::Surface;
use lodc_mesh::{CollapseSequence, Lod, PositionIds, Simplified, SplitMix64, is_degenerate};
use lodc_nearest::{FarthestSearch, TriangleTree};
use rayon::prelude::*;

/// Levels that are measured, spread over the triangle counts. Chosen by hand.
const LEVELS: u32 = 8;

/// The seed by which levels are chosen: any number ("errors" in ASCII).
const SEED: u64 = 0x6572_726f_7273;

/// Fewer samples than [`Sampling::DEFAULT`], and on small surfaces about one a triangle, with the
/// corners and middles of its edges: where a sample is nearly too far, a search follows.
fn sampling(triangles: usize) -> Sampling {
    Sampling {
        samples: triangles.clamp(1_000, 20_000),
        lattice: (6 * triangles).min(30_000),
        seed: 0x5eed,
    }
}

/// Measured distances may be this many times the stored ones, which are made from samples.
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
/// are the surfaces that the errors are the maximum over, each with a position for every vertex:
/// the one at rest first.
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
    let mut upper = f64::from(collapses.parts().triangles);
    let ratio = upper.powf(1.0 / f64::from(LEVELS));
    let mut lods = Vec::new();
    for _ in 0..LEVELS {
        let lower = upper / ratio;
        let triangles = lower + (upper - lower) * f64::from(random.unit());
        lods.push(collapses.lod_for_triangles(triangles as u32).min(collapses.last_visible()));
        upper = lower;
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
    positions: &'a [[f32; 3]],
    /// Vertices at one position at rest are at one position in this shape, so that coincident
    /// triangles stay so.
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
        let distinct: Vec<[u32; 3]> =
            positions.distinct(all).into_iter().map(|t| all[t as usize]).collect();
        let shape = |&shape_positions: &&'a [[f32; 3]]| {
            let first = |v: usize| positions.first_vertex[positions.of_vertex[v] as usize];
            let is_whole = (0..shape_positions.len())
                .all(|v| shape_positions[v] == shape_positions[first(v) as usize]);
            let input =
                surface(shape_positions, if is_whole { distinct.clone() } else { all.to_vec() });
            let area = area(&input);
            Shape {
                positions: shape_positions,
                is_whole,
                diagonal: input.diagonal(),
                input: input.tree(),
                area,
            }
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
            let lower_bound = (square - missed).max(0.0).sqrt();
            let too_small = lower_bound > (RMS_TOLERANCE * rms).max(RMS_OF_PARTS * error) + slack;
            let upper_bound = || {
                // It never falls: a finer level may be the one that is that far.
                let first_step = collapses.parts().step_rms.partition_point(|&r| r < stored);
                let finer = self.changes(collapses.step(first_step).lod);
                (square.max(mean_square_of(&finer, samples)) + missed).sqrt()
            };
            let is_tiny = rms <= tiny || rms <= RMS_OVERSTATED * (square + missed).sqrt();
            if !too_small && (is_tiny || rms <= RMS_OVERSTATED * upper_bound()) {
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
        let too_large_below = error / OVERSTATED;
        let mut is_reached = error <= self.shapes.iter().map(Shape::tiny).fold(0.0, f64::max);
        for (number, shape) in self.shapes.iter().enumerate() {
            let allowed = TOLERANCE * error + shape.slack();
            let farther =
                changes[number].farther_than(if is_reached { allowed } else { too_large_below });
            match farther {
                Some(largest) if largest > allowed => {
                    let pose =
                        if number > 0 { format!(" in pose {number}") } else { String::new() };
                    let what = format!("the error is {stored}, measured are {largest}{pose}");
                    return Some(what);
                }
                farther => is_reached |= farther.is_some(),
            }
        }
        if is_reached {
            return None;
        }
        // Errors never fall: a finer level may be the one that is that far. Samples may miss a
        // small part, so only a bound tells that there is none.
        let first_step = collapses.parts().step_errors.partition_point(|&e| e < stored);
        let finer = self.changes(collapses.step(first_step).lod);
        let search = |shape: &Shape| FarthestSearch::for_size(shape.diagonal);
        let bounds = finer.iter().zip(&self.shapes).map(|(c, shape)| c.bound(search(shape)));
        let bound = bounds.fold(0.0, f64::max);
        (bound < too_large_below)
            .then(|| format!("the error is {stored}, no point is farther than {bound}"))
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
            let (input_changed, same): (Vec<_>, Vec<_>) = all.iter().partition(|t| is_changed(t));
            let level_changed =
                input_changed.iter().copied().map(resolved).filter(is_live).collect();
            let [level, input_changed, level_changed, same] =
                [shown.clone(), input_changed, level_changed, same]
                    .map(|triangles| surface(shape.positions, triangles));
            let areas = [shape.area, area(&same) + area(&level_changed)];
            let level = level.tree();
            changes.push(Changes {
                input: &shape.input,
                level,
                input_changed,
                level_changed,
                areas,
            });
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
    input_changed: Surface,
    level_changed: Surface,
    /// Twice the areas of the whole input and of the whole level; faces on each other count once.
    areas: [f64; 2],
}

impl Changes<'_> {
    /// Returns the largest distance that samples find, either way, if it is more than `bound`.
    fn farther_than(&self, bound: f64) -> Option<f64> {
        let one_way = |from: &Surface, to: &TriangleTree| {
            farther_than(from, to, bound, &sampling(from.triangles.len()))
        };
        let (forward, backward) = rayon::join(
            || one_way(&self.input_changed, &self.level),
            || one_way(&self.level_changed, self.input),
        );
        forward.into_iter().chain(backward).max_by(f64::total_cmp)
    }

    /// The mean squared distance over the whole area, the larger of both ways. What is the same on
    /// both sides adds area alone.
    fn mean_square(&self, samples: usize) -> f64 {
        let one_way = |changed: &Surface, to: &TriangleTree, all: f64| {
            let share = area(changed) / all;
            if share > 0.0 { share * mean_square(changed, to, samples, SEED) } else { 0.0 }
        };
        let (forward, backward) = rayon::join(
            || one_way(&self.input_changed, &self.level, self.areas[0]),
            || one_way(&self.level_changed, self.input, self.areas[1]),
        );
        forward.max(backward)
    }

    /// An upper bound of the distance, either way.
    fn bound(&self, search: FarthestSearch) -> f64 {
        let upper_bound = |from: &Surface, to: &TriangleTree| {
            let corners: Vec<_> = (0..from.triangles.len()).map(|t| from.corners(t)).collect();
            search.farthest(&corners, to).upper
        };
        let (forward, backward) = rayon::join(
            || upper_bound(&self.input_changed, &self.level),
            || upper_bound(&self.level_changed, self.input),
        );
        forward.max(backward)
    }
}

/// Twice the area of a surface.
fn area(surface: &Surface) -> f64 {
    let doubled_area = |t| {
        let [a, b, c] = surface.corners(t);
        (b - a).cross(c - a).length()
    };
    (0..surface.triangles.len()).map(doubled_area).sum()
}

fn surface(shape: &[[f32; 3]], triangles: Vec<[u32; 3]>) -> Surface {
    let positions = shape.iter().map(|&p| p.into()).collect();
    Surface { positions, triangles, ..Surface::default() }
}
