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

// The following factors are chosen by hand.

/// A measured distance may be at most this many times the stored error, which is made from samples.
const MAX_MEASURED: f64 = 1.05;

/// A stored error may be at most this many times the largest distance.
const MAX_STORED: f64 = 3.0;

/// A measured root mean square distance may be at most this many times the stored one. Both are
/// means of samples.
const MAX_MEASURED_RMS: f64 = 1.9;

/// Root mean square distances below this share of the error are not refused for being stored too
/// small: a hundredth of the surface can cause them, which the writer's samples may have missed.
const MIN_REFUSED_RMS: f64 = 0.125;

/// A stored root mean square distance may be at most this many times the measured one: samples
/// that follow the surface from level to level stop when they are near enough.
const MAX_STORED_RMS: f64 = 8.0;

/// Samples of a root mean square distance: at first, and before it is refused.
const RMS_SAMPLES: [u32; 2] = [2_000, 20_000];

/// Number of slices of equal area by which a mean is corrected, for parts that samples may have
/// missed: all `n` samples miss a part of 3/n of the area with a chance of 5 %.
const MISSED_SLICES: f64 = 3.0;

/// Compares the errors and root mean square distances of a sequence with measured ones. Returns the
/// number of levels that were measured, and the problem of the first level whose errors do not
/// hold. `shapes` are the surfaces that the errors are the maximum over, each with a position for
/// every vertex: the one at rest first.
#[must_use]
pub fn check_errors<S: AsRef<[[f32; 3]]> + Sync>(
    simplified: &Simplified,
    shapes: &[S],
) -> (usize, Option<String>) {
    let lods = levels(simplified.collapses());
    let shapes: Vec<&[[f32; 3]]> = shapes.iter().map(AsRef::as_ref).collect();
    (lods.len(), first_difference(simplified, &shapes, &lods))
}

/// Returns levels with triangles, a random one from each of [`LEVELS`] ranges of triangle counts.
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

/// Returns the problem of the first level whose errors do not hold.
fn first_difference(
    simplified: &Simplified,
    shapes: &[&[[f32; 3]]],
    lods: &[Lod],
) -> Option<String> {
    let levels = Levels::new(simplified, shapes);
    let check = |&lod: &Lod| Some(format!("LOD {}: {}", lod.0, levels.check(lod)?));
    let problems: Vec<Option<String>> = lods.par_iter().with_max_len(1).map(check).collect();
    problems.into_iter().flatten().next()
}

/// The levels of a sequence, prepared for measuring.
struct Levels<'a> {
    simplified: &'a Simplified,
    positions: PositionIds,
    /// The triangles of LOD 0 without those that lie on an earlier one, as they do at every level.
    distinct: Vec<[u32; 3]>,
    shapes: Vec<Shape<'a>>,
}

/// The input in one shape.
struct Shape<'a> {
    positions: &'a [[f32; 3]],
    /// True if vertices at one position at rest are at one position in this shape, so that
    /// triangles that lie on each other still do.
    is_whole: bool,
    /// The triangles of LOD 0.
    input: TriangleTree,
    diagonal: f64,
    /// Twice the area.
    area: f64,
}

impl Shape<'_> {
    /// Distances up to this are rounding errors: single precision rounds numbers as large as the
    /// diagonal by about as much.
    fn rounding(&self) -> f64 {
        1e-7 * self.diagonal
    }

    /// Errors up to this are not refused for being too large. Chosen by hand.
    fn negligible(&self) -> f64 {
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
        let rounding = self.shapes.iter().map(Shape::rounding).fold(0.0, f64::max);
        let negligible = self.shapes.iter().map(Shape::negligible).fold(0.0, f64::max);
        let mut measured = 0.0;
        for samples in RMS_SAMPLES {
            // No point is farther than the error, so missed parts change the mean by no more.
            let missed = MISSED_SLICES / f64::from(samples) * error * error;
            let square = mean_square_of(changes, samples);
            let lower_bound = (square - missed).max(0.0).sqrt();
            let refused_above = (MAX_MEASURED_RMS * rms).max(MIN_REFUSED_RMS * error) + rounding;
            let is_too_small = lower_bound > refused_above;
            let upper_bound = || {
                // Stored ones never fall: a finer level may be the one with that distance.
                let first_step = collapses.parts().step_rms.partition_point(|&r| r < stored);
                let finer = self.changes(collapses.step(first_step).lod);
                (square.max(mean_square_of(&finer, samples)) + missed).sqrt()
            };
            let is_reached = rms <= negligible || rms <= MAX_STORED_RMS * (square + missed).sqrt();
            if !is_too_small && (is_reached || rms <= MAX_STORED_RMS * upper_bound()) {
                return None;
            }
            measured = square.sqrt();
        }
        Some(format!("the root mean square distance is {stored}, measured are {measured}"))
    }

    /// Returns the problem of a level's stored error. One shape with a distance close to it shows
    /// that it is not too large; the other shapes are only searched for larger distances.
    fn check_error(&self, lod: Lod, changes: &[Changes<'_>]) -> Option<String> {
        let collapses = self.simplified.collapses();
        let stored = collapses.error_at(lod);
        let error = f64::from(stored);
        let min_distance = error / MAX_STORED;
        let mut is_reached = error <= self.shapes.iter().map(Shape::negligible).fold(0.0, f64::max);
        for (number, shape) in self.shapes.iter().enumerate() {
            let allowed = MAX_MEASURED * error + shape.rounding();
            let farther =
                changes[number].farther_than(if is_reached { allowed } else { min_distance });
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
        // Errors never fall: a finer level may be the one with that distance. Samples may miss a
        // small part, so only an upper bound shows that the error is too large.
        let first_step = collapses.parts().step_errors.partition_point(|&e| e < stored);
        let finer = self.changes(collapses.step(first_step).lod);
        let search = |shape: &Shape| FarthestSearch::for_size(shape.diagonal);
        let bounds = finer.iter().zip(&self.shapes).map(|(c, shape)| c.bound(search(shape)));
        let bound = bounds.fold(0.0, f64::max);
        (bound < min_distance)
            .then(|| format!("the error is {stored}, no point is farther than {bound}"))
    }

    /// The changes of a level in each shape. Triangles that it has in common with the input have no
    /// distance, so only the others are measured.
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

/// The changes of a level in one shape.
struct Changes<'a> {
    /// All triangles of the input.
    input: &'a TriangleTree,
    /// All triangles of the level.
    level: TriangleTree,
    /// Triangles of the input that the level does not have.
    input_changed: Surface,
    /// Triangles of the level that the input does not have.
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

    /// The mean squared distance over the whole area, the larger of both ways. Common triangles add
    /// area alone.
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
