//! The iteration: tie both surfaces together, solve for the moves, guard them, keep the best.

use crate::charts::curves;
use crate::guard::{Guard, cross};
use crate::input::Input;
use crate::level::Level;
use crate::nearest::{Tree, at, segment_tree};
use crate::quadrature::SIX;
use crate::system::{System, Tie};
use glam::DVec3;
use lodc_mesh::NONE;
use rayon::prelude::*;

/// Distances below this share of the diagonal have no direction worth following.
const TINY: f64 = 1e-7;
/// Most that a point moves in one iteration, in mean edge lengths around it.
const STEP: f64 = 0.5;
/// Most that a point ends up from where it was, in mean edge lengths there.
const WHOLE: f64 = 1.0;
/// Points on each curve edge of the level.
const ON_CURVE: usize = 4;
/// Samples that are looked up in parallel before they are added up in order, and those that one
/// thread looks up one after the other, each with the last one's triangle as a hint.
const BLOCK: usize = 1 << 16;
const RUN: usize = 1 << 8;
/// Root mean square distance, as a share of the diagonal, below which a level is left alone.
const ENOUGH: f64 = 1e-5;

/// Points of the level on their way to a better fit.
pub(crate) struct Fit<'a> {
    input: &'a Input,
    level: &'a Level,
    /// Normals of the faces where the simplifier left them.
    first_normals: Vec<DVec3>,
    first_lengths: Vec<f64>,
    /// Curves of the level, as `3 * face + corner`.
    curves: Vec<u32>,
    /// The face that each sample was nearest to, and the input triangle of each backward point.
    hints: Vec<u32>,
    backward_hints: Vec<u32>,
}

/// One look at both surfaces.
struct Ties<'a> {
    system: System<'a>,
    /// Mean squared distance, both directions added.
    energy: f64,
    input_normals: Vec<DVec3>,
}

impl<'a> Fit<'a> {
    pub(crate) fn new(input: &'a Input, level: &'a Level) -> Self {
        let chart: Vec<u32> = level.source.iter().map(|&t| input.chart[t as usize]).collect();
        let normal = |corners| cross(corners).normalize_or_zero();
        Self {
            input,
            level,
            first_normals: level.corners(&level.points).into_iter().map(normal).collect(),
            first_lengths: level.edge_lengths(&level.points),
            curves: curves(&level.faces, &chart),
            hints: vec![NONE; input.samples()],
            backward_hints: vec![NONE; SIX.len() * level.faces.len()],
        }
    }

    /// Returns the best positions of the points that `iterations` find.
    pub(crate) fn run(mut self, iterations: u32) -> Vec<DVec3> {
        let mut positions = self.level.points.clone();
        let mut best = (f64::INFINITY, positions.clone());
        for iteration in 0..=iterations {
            let ties = self.tie(&positions);
            if ties.energy < best.0 {
                best = (ties.energy, positions.clone());
            }
            if ties.energy.sqrt() < ENOUGH * self.input.diagonal {
                break;
            }
            if iteration < iterations {
                let Ties { system, input_normals, .. } = ties;
                let moves = self.clamped(&positions, &system.solve());
                let guard = Guard {
                    level: self.level,
                    first_normals: &self.first_normals,
                    input_normals: &input_normals,
                };
                positions = guard.limit(&positions, &moves);
            }
        }
        best.1
    }

    /// Limits moves to half an edge now, and to one edge in all.
    fn clamped(&self, positions: &[DVec3], moves: &[DVec3]) -> Vec<DVec3> {
        let lengths = self.level.edge_lengths(positions);
        (0..positions.len())
            .map(|i| {
                let step = moves[i].clamp_length_max(STEP * lengths[i]);
                let first = self.level.points[i];
                let whole = positions[i] + step - first;
                first + whole.clamp_length_max(WHOLE * self.first_lengths[i]) - positions[i]
            })
            .map(|m| if m.is_finite() { m } else { DVec3::ZERO })
            .collect()
    }

    fn tie(&mut self, positions: &[DVec3]) -> Ties<'a> {
        let corners = self.level.corners(positions);
        let crosses: Vec<DVec3> = corners.iter().map(|&t| cross(t)).collect();
        let level = self.level;
        let system = System::new(positions.len(), &level.faces, &level.face_edges, &level.edges);
        let mut ties = Ties { system, energy: 0.0, input_normals: vec![] };
        self.tie_input(&corners, &crosses, &mut ties);
        self.tie_level(&corners, &crosses, &mut ties);
        self.tie_curves(&corners, &mut ties);
        ties
    }

    /// From the input's samples to the level.
    fn tie_input(&mut self, corners: &[[DVec3; 3]], crosses: &[DVec3], ties: &mut Ties<'_>) {
        let (input, tree) = (self.input, Tree::new(corners));
        let tiny = (TINY * input.diagonal).powi(2);
        for (block, hints) in self.hints.chunks_mut(BLOCK).enumerate() {
            let look = |i: usize, hint: u32| {
                let (p, weight) = input.sample(i);
                let found = tree.nearest(p, hint)?;
                let face = found.triangle as usize;
                let residual = at(corners[face], found.barycentric) - p;
                let normal = crosses[face].normalize_or_zero();
                let direction = direction(residual, found.squared, tiny, normal);
                let tie = Tie {
                    face: found.triangle,
                    barycentric: found.barycentric,
                    residual,
                    direction,
                    weight,
                };
                Some((tie, weight * found.squared))
            };
            let run = |(run, hints): (usize, &mut [u32])| -> Vec<(Tie, f64)> {
                let (first, mut last) = (BLOCK * block + RUN * run, NONE);
                let one = |(i, hint): (usize, &mut u32)| {
                    let guess = if *hint == NONE { last } else { *hint };
                    let found = look(first + i, guess);
                    *hint = found.map_or(NONE, |f| f.0.face);
                    last = *hint;
                    found
                };
                hints.iter_mut().enumerate().filter_map(one).collect()
            };
            let found: Vec<_> = hints.par_chunks_mut(RUN).enumerate().map(run).collect();
            for (tie, energy) in found.into_iter().flatten() {
                ties.system.add(&tie);
                ties.energy += energy;
            }
        }
    }

    /// From points on the level's faces to the input.
    fn tie_level(&mut self, corners: &[[DVec3; 3]], crosses: &[DVec3], ties: &mut Ties<'_>) {
        let input = self.input;
        let tiny = (TINY * input.diagonal).powi(2);
        let area = crosses.iter().map(|c| c.length()).sum::<f64>().max(f64::MIN_POSITIVE);
        let look = |(face, hints): (usize, &mut [u32])| {
            let mut normal = DVec3::ZERO;
            let mut found = [None; SIX.len()];
            for (k, (barycentric, share)) in SIX.iter().enumerate() {
                let q = at(corners[face], *barycentric);
                let hint = if hints[k] == NONE { hints[k.saturating_sub(1)] } else { hints[k] };
                let Some(nearest) = input.tree.nearest(q, hint) else { continue };
                hints[k] = nearest.triangle;
                let there = nearest.triangle as usize;
                normal += input.normals[there] * *share;
                let residual = q - input.at(there, nearest.barycentric);
                let direction = direction(residual, nearest.squared, tiny, input.normals[there]);
                let weight = crosses[face].length() * share / area;
                let (face, barycentric) = (face as u32, *barycentric);
                let tie = Tie { face, barycentric, residual, direction, weight };
                found[k] = Some((tie, weight * nearest.squared));
            }
            (found, normal.normalize_or_zero())
        };
        let hints = self.backward_hints.par_chunks_mut(SIX.len());
        let found: Vec<_> = hints.enumerate().map(look).collect();
        for (points, normal) in found {
            ties.input_normals.push(normal);
            for (tie, energy) in points.into_iter().flatten() {
                ties.system.add(&tie);
                ties.energy += energy;
            }
        }
    }

    /// Between the curves of both surfaces: borders, borders of materials, seams of charts.
    fn tie_curves(&self, corners: &[[DVec3; 3]], ties: &mut Ties<'_>) {
        let (input, sides) = (self.input, &self.curves);
        if sides.is_empty() || input.curve_points.is_empty() {
            return;
        }
        let ends = |side: u32| {
            let (t, k) = (corners[side as usize / 3], side as usize % 3);
            [t[k], t[(k + 1) % 3]]
        };
        let segments: Vec<[DVec3; 2]> = sides.iter().map(|&side| ends(side)).collect();
        let lengths: Vec<f64> = segments.iter().map(|[a, b]| a.distance(*b)).collect();
        // Curves weigh as bands of the mean width of a face.
        let band = mean_edge(corners) / input.area.max(f64::MIN_POSITIVE);
        let tree = segment_tree(&segments);
        let tie = |segment: usize, t: f64, residual: DVec3, weight: f64| {
            let (side, mut barycentric) = (sides[segment], [0.0; 3]);
            let k = side as usize % 3;
            (barycentric[k], barycentric[(k + 1) % 3]) = (1.0 - t, t);
            let direction = residual.normalize_or_zero();
            Tie { face: side / 3, barycentric, residual, direction, weight }
        };
        let there: Vec<Option<Tie>> = (input.curve_points.par_iter().zip(&input.curve_lengths))
            .map(|(&p, length)| {
                let found = tree.nearest(p, NONE)?;
                let (segment, t) = (found.triangle as usize, 1.0 - found.barycentric[0]);
                let [a, b] = segments[segment];
                Some(tie(segment, t, a.lerp(b, t) - p, length * band))
            })
            .collect();
        let back: Vec<Option<Tie>> = (0..ON_CURVE * segments.len())
            .into_par_iter()
            .map(|i| {
                let (segment, k) = (i / ON_CURVE, i % ON_CURVE);
                let t = (k as f64 + 0.5) / ON_CURVE as f64;
                let q = segments[segment][0].lerp(segments[segment][1], t);
                let found = input.curve_tree.nearest(q, NONE)?;
                let p = input.on_curve(found.triangle as usize, 1.0 - found.barycentric[0]);
                Some(tie(segment, t, q - p, lengths[segment] / ON_CURVE as f64 * band))
            })
            .collect();
        there.into_iter().chain(back).flatten().for_each(|tie| ties.system.add(&tie));
    }
}

/// The mean length of the sides of triangles.
fn mean_edge(corners: &[[DVec3; 3]]) -> f64 {
    let perimeter = |[a, b, c]: &[DVec3; 3]| a.distance(*b) + b.distance(*c) + c.distance(*a);
    corners.iter().map(perimeter).sum::<f64>() / (3 * corners.len()).max(1) as f64
}

/// The unit direction of a residual, or the normal where it is too short to have one.
fn direction(residual: DVec3, squared: f64, tiny: f64, normal: DVec3) -> DVec3 {
    if squared < tiny { normal } else { residual / squared.sqrt() }
}
