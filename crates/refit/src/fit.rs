//! The iteration of a refit: tie samples of each surface to the nearest point of the other, solve
//! least squares for the moves of the points, guard faces against turning over, and keep the best
//! state.

use crate::by_face::{ByFace, hardly_closer, within_reach};
use crate::charts::curves;
use crate::guard::{Guard, cross};
use crate::input::Input;
use crate::level::Level;
use crate::quadrature::SIX;
use crate::system::{System, Tie};
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{TriangleTree, point_at};
use rayon::prelude::*;

/// Distances below this share of the diagonal have no direction worth following.
const TINY_SHARE: f64 = 1e-7;
/// The most that a point moves in one iteration, in mean edge lengths around it. Chosen by hand.
const MAX_STEP: f64 = 0.5;
/// The most that a point moves in all, in mean edge lengths around its start. Chosen by hand.
const MAX_MOVE: f64 = 1.0;
/// Points on each curve edge of the level. Chosen by hand.
const ON_CURVE: usize = 4;
/// Samples, or faces, that are looked up in parallel before they are added up in order.
const SAMPLES_PER_BLOCK: usize = 1 << 14;
/// Samples that one thread looks up one after the other, each with the last one's triangle as a
/// hint.
const SAMPLES_PER_THREAD: usize = 1 << 8;
/// The most that a sample's squared distance may become, as a share of the farthest sample's at the
/// start: 5 % more in distance. Chosen by hand.
const MAX_FARTHEST: f64 = 1.05 * 1.05;
/// Number of times that points with samples beyond the limit are held back. Chosen by hand.
const HELD_ROUNDS: usize = 4;
/// The share of the squared distance at the start that points which come farther may add. Chosen by
/// hand.
const MAX_SPOILT: f64 = 0.02;
/// Root mean square distance, as a share of the diagonal, below which a level is not refitted
/// further: rounding of `f32` coordinates.
const GOOD_ENOUGH: f64 = 1e-6;

/// Points of the level on their way to a better fit.
pub(crate) struct Fit<'a> {
    input: &'a Input,
    level: &'a Level,
    /// Normals of the faces where the simplifier left them.
    first_normals: Vec<DVec3>,
    first_lengths: Vec<f64>,
    /// Curves of the level, as `3 * face + corner`.
    curves: Vec<u32>,
    /// The tree of the faces, which follows them.
    tree: TriangleTree,
    /// The face that each sample was nearest to, and the input triangle of each backward point, by
    /// the order of the tree.
    hints: Vec<u32>,
    backward_hints: Vec<u32>,
}

/// The ties between both surfaces at one state of the points.
struct Ties<'a> {
    system: System<'a>,
    /// Mean squared distance, both directions added.
    energy: f64,
    by_face: ByFace,
    input_normals: Vec<DVec3>,
}

/// Distances of the level where the simplifier left it.
struct UnmovedDistances {
    /// Mean squared distance, both directions added.
    energy: f64,
    /// The same around each point.
    around: Vec<f64>,
    /// Most that a squared distance of any sample may become.
    limit: f64,
}

impl UnmovedDistances {
    /// Marks the points that come farther than they were, if they spoil more than a little of the
    /// whole; returns whether any was not marked before.
    fn hold_worse(&self, energies_around: &[f64], held: &mut [bool]) -> bool {
        let worse = |p: usize| energies_around[p] - self.around[p];
        let spoilt: f64 = (0..held.len()).map(|p| worse(p).max(0.0)).sum();
        if spoilt <= MAX_SPOILT * self.around.iter().sum::<f64>() {
            return false;
        }
        let mut new = false;
        for p in (0..held.len()).filter(|&p| worse(p) > 0.0) {
            new |= !held[p];
            held[p] = true;
        }
        new
    }
}

impl Ties<'_> {
    /// Adds a tie of a sample at some squared distance.
    fn add(&mut self, (tie, squared): &(Tie, f64)) {
        self.system.add(tie);
        self.energy += tie.weight * squared;
        self.by_face.add(tie, *squared);
    }
}

impl<'a> Fit<'a> {
    pub(crate) fn new(input: &'a Input, level: &'a Level) -> Self {
        let chart: Vec<u32> = level.source.iter().map(|&t| input.chart[t as usize]).collect();
        let normal = |corners| cross(corners).normalize_or_zero();
        let tree = TriangleTree::new(&level.corners(&level.points));
        // A face lies near the triangle that it was.
        let hint = |&face: &u32| [level.source[face as usize]; SIX.len()];
        let backward_hints = tree.spatial_order().iter().flat_map(hint).collect();
        Self {
            input,
            level,
            first_normals: level.corners(&level.points).into_iter().map(normal).collect(),
            first_lengths: level.edge_lengths(&level.points),
            curves: curves(&level.faces, &chart),
            hints: vec![NONE; input.samples()],
            backward_hints,
            tree,
        }
    }

    /// Returns the best positions of the points that `iterations` find. No sample ends up much
    /// farther from the other surface than the farthest was at the start.
    pub(crate) fn run(mut self, iterations: u32, tick: &(dyn Fn() + Sync)) -> Vec<DVec3> {
        let (points, faces) = (&self.level.points, &self.level.faces);
        let start = self.tie(points);
        let limit = MAX_FARTHEST * start.by_face.farthest();
        let first = UnmovedDistances {
            energy: start.energy,
            around: self.energies_around(&start.by_face),
            limit,
        };
        let (mut best, mut positions) = (None, points.clone());
        let (mut least_energy, mut ties) = (first.around.iter().sum(), start);
        for _ in 0..iterations {
            tick();
            if ties.energy.sqrt() < GOOD_ENOUGH * self.input.diagonal {
                break;
            }
            let moves = self.clamped(&positions, &ties.system.solve());
            positions = self.guard(&ties.input_normals).limit(&positions, &moves);
            ties = self.tie(&positions);
            let energies_around = self.energies_around(&ties.by_face);
            let energy_within_reach = within_reach(&first.around, &energies_around);
            if energy_within_reach < least_energy {
                least_energy = energy_within_reach;
                best =
                    Some((positions.clone(), ties.energy, ties.by_face.clone(), energies_around));
            }
        }
        let Some((best, energy, by_face, energies_around)) = best else { return points.clone() };
        let mut held = hardly_closer(&first.around, &energies_around, faces);
        let is_good = energy < first.energy && by_face.farthest() <= limit && !held.contains(&true);
        if !first.hold_worse(&energies_around, &mut held) && is_good {
            return best;
        }
        let held = self.held_back(&best, held, by_face, &ties.input_normals, &first);
        let ties = self.tie(&held);
        let max_energy = if is_good { energy } else { first.energy };
        match () {
            () if ties.energy < max_energy && ties.by_face.farthest() <= limit => held,
            () if is_good => best,
            () => self.level.points.clone(),
        }
    }

    fn energies_around(&self, by_face: &ByFace) -> Vec<f64> {
        by_face.around(&self.level.faces, self.level.points.len())
    }

    /// Puts the points that are `held`, and the corners of faces with a sample beyond the limit,
    /// back to their start, with a ring of neighbours more each time, and points that come farther,
    /// until no sample is beyond and hardly any point comes farther.
    fn held_back(
        &mut self,
        moved: &[DVec3],
        mut held: Vec<bool>,
        mut by_face: ByFace,
        input_normals: &[DVec3],
        first: &UnmovedDistances,
    ) -> Vec<DVec3> {
        let level = self.level;
        let mut beyond_limit = vec![false; moved.len()];
        let mut positions = moved.to_vec();
        for _ in 0..HELD_ROUNDS {
            let touched = |f: &usize| {
                let is_beyond = |&p: &u32| beyond_limit[p as usize];
                by_face.farthest_of(*f) > first.limit || level.faces[*f].iter().any(is_beyond)
            };
            let affected_faces: Vec<usize> = (0..level.faces.len()).filter(touched).collect();
            for &p in affected_faces.iter().flat_map(|&f| &level.faces[f]) {
                beyond_limit[p as usize] = true;
                held[p as usize] = true;
            }
            let moves: Vec<DVec3> = (0..moved.len())
                .map(|p| if held[p] { DVec3::ZERO } else { moved[p] - level.points[p] })
                .collect();
            positions = self.guard(input_normals).limit(&level.points, &moves);
            by_face = self.tie(&positions).by_face;
            let got_worse = first.hold_worse(&self.energies_around(&by_face), &mut held);
            if by_face.farthest() <= first.limit && !got_worse {
                break;
            }
        }
        positions
    }

    fn guard<'g>(&'g self, input_normals: &'g [DVec3]) -> Guard<'g> {
        Guard { level: self.level, first_normals: &self.first_normals, input_normals }
    }

    /// Limits moves to half an edge now, and to one edge in all.
    fn clamped(&self, positions: &[DVec3], moves: &[DVec3]) -> Vec<DVec3> {
        let lengths = self.level.edge_lengths(positions);
        (0..positions.len())
            .map(|i| {
                let step = moves[i].clamp_length_max(MAX_STEP * lengths[i]);
                let first = self.level.points[i];
                let total = positions[i] + step - first;
                first + total.clamp_length_max(MAX_MOVE * self.first_lengths[i]) - positions[i]
            })
            .map(|m| if m.is_finite() { m } else { DVec3::ZERO })
            .collect()
    }

    fn tie(&mut self, positions: &[DVec3]) -> Ties<'a> {
        let corners = self.level.corners(positions);
        self.tree.move_to(&corners);
        let crosses: Vec<DVec3> = corners.iter().map(|&t| cross(t)).collect();
        let level = self.level;
        let system = System::new(positions.len(), &level.faces, &level.face_edges, &level.edges);
        let by_face = ByFace::new(level.faces.len());
        let input_normals = vec![DVec3::ZERO; level.faces.len()];
        let mut ties = Ties { system, energy: 0.0, by_face, input_normals };
        self.tie_input(&corners, &crosses, &mut ties);
        self.tie_level(&corners, &crosses, &mut ties);
        self.tie_curves(&corners, &mut ties);
        ties
    }

    /// From the input's samples to the level.
    fn tie_input(&mut self, corners: &[[DVec3; 3]], crosses: &[DVec3], ties: &mut Ties<'_>) {
        let (input, tree) = (self.input, &self.tree);
        let tiny = (TINY_SHARE * input.diagonal).powi(2);
        for (block, hints) in self.hints.chunks_mut(SAMPLES_PER_BLOCK).enumerate() {
            let tie_sample = |i: usize, hint: u32| {
                let (p, weight) = input.sample(i);
                let nearest = tree.nearest(p, hint)?;
                let face = nearest.triangle as usize;
                let residual = point_at(corners[face], nearest.barycentric) - p;
                let normal = crosses[face].normalize_or_zero();
                let direction = direction(residual, nearest.squared, tiny, normal);
                let tie = Tie {
                    face: nearest.triangle,
                    barycentric: nearest.barycentric,
                    residual,
                    direction,
                    weight,
                };
                Some((tie, nearest.squared))
            };
            let run = |(run, hints): (usize, &mut [u32])| -> Vec<(Tie, f64)> {
                let (first, mut last) =
                    (SAMPLES_PER_BLOCK * block + SAMPLES_PER_THREAD * run, NONE);
                let tie_next = |(i, hint): (usize, &mut u32)| {
                    let guess = if *hint == NONE { last } else { *hint };
                    let nearest = tie_sample(first + i, guess);
                    *hint = nearest.map_or(NONE, |f| f.0.face);
                    last = *hint;
                    nearest
                };
                hints.iter_mut().enumerate().filter_map(tie_next).collect()
            };
            let nearest: Vec<_> =
                hints.par_chunks_mut(SAMPLES_PER_THREAD).enumerate().map(run).collect();
            nearest.iter().flatten().for_each(|nearest| ties.add(nearest));
        }
    }

    /// From points on the level's faces to the input.
    fn tie_level(&mut self, corners: &[[DVec3; 3]], crosses: &[DVec3], ties: &mut Ties<'_>) {
        let input = self.input;
        let tiny = (TINY_SHARE * input.diagonal).powi(2);
        let area = crosses.iter().map(|c| c.length()).sum::<f64>().max(f64::MIN_POSITIVE);
        let tie_face = |(face, hints): (&u32, &mut [u32])| {
            let (face, mut normal) = (*face as usize, DVec3::ZERO);
            let mut found = [None; SIX.len()];
            for (k, (barycentric, share)) in SIX.iter().enumerate() {
                let q = point_at(corners[face], *barycentric);
                let hint = if hints[k] == NONE { hints[k.saturating_sub(1)] } else { hints[k] };
                let Some(nearest) = input.tree.nearest(q, hint) else { continue };
                hints[k] = nearest.triangle;
                let input_triangle = nearest.triangle as usize;
                normal += input.normals[input_triangle] * *share;
                let residual = q - input.at(input_triangle, nearest.barycentric);
                let direction =
                    direction(residual, nearest.squared, tiny, input.normals[input_triangle]);
                let weight = crosses[face].length() * share / area;
                let (face, barycentric) = (face as u32, *barycentric);
                let tie = Tie { face, barycentric, residual, direction, weight };
                found[k] = Some((tie, nearest.squared));
            }
            (found, normal.normalize_or_zero())
        };
        let blocks = self.backward_hints.chunks_mut(SAMPLES_PER_BLOCK * SIX.len());
        for (faces, hints) in self.tree.spatial_order().chunks(SAMPLES_PER_BLOCK).zip(blocks) {
            let hints = hints.par_chunks_mut(SIX.len());
            let found: Vec<_> = faces.par_iter().zip(hints).map(tie_face).collect();
            for (&face, (points, normal)) in faces.iter().zip(found) {
                ties.input_normals[face as usize] = normal;
                points.iter().flatten().for_each(|found| ties.add(found));
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
        let tree = TriangleTree::of_segments(&segments);
        let tie = |segment: usize, t: f64, residual: DVec3, weight: f64| {
            let (side, mut barycentric) = (sides[segment], [0.0; 3]);
            let k = side as usize % 3;
            (barycentric[k], barycentric[(k + 1) % 3]) = (1.0 - t, t);
            let direction = residual.normalize_or_zero();
            Tie { face: side / 3, barycentric, residual, direction, weight }
        };
        let from_input: Vec<Option<Tie>> =
            (input.curve_points.par_iter().zip(&input.curve_lengths))
                .map(|(&p, length)| {
                    let found = tree.nearest(p, NONE)?;
                    let (segment, t) = (found.triangle as usize, 1.0 - found.barycentric[0]);
                    let [a, b] = segments[segment];
                    Some(tie(segment, t, a.lerp(b, t) - p, length * band))
                })
                .collect();
        let from_level: Vec<Option<Tie>> = (0..ON_CURVE * segments.len())
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
        from_input.into_iter().chain(from_level).flatten().for_each(|tie| ties.system.add(&tie));
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
