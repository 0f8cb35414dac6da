//! The iteration of a refit: tie samples of each surface to the nearest point of the other, solve
//! least squares for the moves of the points, guard faces against turning over, and keep the best
//! state.

use crate::charts::curves;
use crate::face_distances::{FaceDistances, barely_closer, energy_if_worse_stay};
use crate::guard::{Guard, cross};
use crate::input::Input;
use crate::level::CoarseMesh;
use crate::neighbours::Neighbours;
use crate::quadrature::MAX_POINTS;
use crate::sheets::{Sheet, nearest_of_sheet};
use crate::system::{System, Tie};
use glam::DVec3;
use lodc_mesh::NONE;
use lodc_nearest::{TriangleTree, point_at};
use rayon::prelude::*;

/// Distances below this share of the diagonal have no direction worth following. Chosen by hand.
const TINY_SHARE: f64 = 1e-7;
/// The most that a point moves in one iteration, in mean edge lengths around it. Chosen by hand.
const MAX_STEP: f64 = 0.5;
/// The most that a point moves in all, in mean edge lengths around its start. Chosen by hand.
const MAX_MOVE: f64 = 1.0;
/// Points on each curve edge of the level that are tied to the input. Chosen by hand.
const POINTS_PER_CURVE_EDGE: usize = 4;
/// Samples, or faces, that are looked up in parallel before they are added up in order: bounds the
/// memory of their ties. Chosen by hand.
const SAMPLES_PER_BLOCK: usize = 1 << 12;
/// Samples that one thread looks up one after the other, each with the last one's triangle as a
/// hint. Chosen by hand.
const SAMPLES_PER_THREAD: usize = 1 << 8;
/// The most that any sample's distance may become, over the farthest sample's at the start. Chosen
/// by hand.
const MAX_RATIO: f64 = 1.05;
/// Most rounds in which points with samples beyond that are held back. Chosen by hand.
const MAX_HOLD_ROUNDS: usize = 3;
/// The share of the energy at the start by which points that get worse may raise it in all. Chosen
/// by hand.
const MAX_WORSE_SHARE: f64 = 0.02;
/// Root mean square distance, as a share of the diagonal, below which a level is not refitted
/// further: what is left is rounding of `f32` coordinates.
const GOOD_ENOUGH_SHARE: f64 = 1e-6;

/// The positions that fit the input best, and what was found on the way there.
pub(crate) struct Fitted {
    pub(crate) input: Input,
    /// One for each point of the level.
    pub(crate) positions: Vec<DVec3>,
    /// A point of one of both surfaces was at least this far from the other where the simplifier
    /// left the level.
    pub(crate) first_distance: f64,
    /// The tree of the level's faces.
    pub(crate) tree: TriangleTree,
    /// The face that each sample of the input was nearest to last.
    pub(crate) hints: Vec<u32>,
    /// The input triangle that each point of the level's faces was nearest to last, in the order of
    /// the tree.
    pub(crate) backward_hints: Vec<u32>,
    /// Where the points were when samples were looked up last.
    looked_up_at: Vec<DVec3>,
    /// How far from a sample its own sheet is looked for at least.
    pub(crate) reach: f64,
}

impl Fitted {
    /// Returns by face whether its points at `positions` are where they were when samples were
    /// looked up last.
    pub(crate) fn stayed(&self, level: &CoarseMesh, positions: &[DVec3]) -> Vec<bool> {
        stayed(level, &self.looked_up_at, positions)
    }
}

/// Returns by face whether its points are at one place in both.
fn stayed(level: &CoarseMesh, before: &[DVec3], now: &[DVec3]) -> Vec<bool> {
    let has_stayed = |face: &[u32; 3]| face.iter().all(|&p| before[p as usize] == now[p as usize]);
    level.faces.iter().map(has_stayed).collect()
}

/// Returns the best positions of the points of a level that `iterations` find. No sample ends up
/// much farther from the other surface than the farthest was at the start.
pub(crate) fn fit(
    input: Input,
    level: &CoarseMesh,
    iterations: u32,
    tick: &(dyn Fn() + Sync),
) -> Fitted {
    let mut fit = Fit::new(&input, level);
    let (positions, first_distance) = fit.run(iterations, tick);
    let Fit { tree, hints, backward_hints, looked_up_at, reach, .. } = fit;
    Fitted { input, positions, first_distance, tree, hints, backward_hints, looked_up_at, reach }
}

/// Points of the level on their way to a better fit.
struct Fit<'a> {
    input: &'a Input,
    level: &'a CoarseMesh,
    /// Normals of the faces where the simplifier left them.
    first_normals: Vec<DVec3>,
    /// The mean edge length around each point where the simplifier left it.
    first_edge_lengths: Vec<f64>,
    /// Curve edges of the level, as `3 * face + corner`.
    curves: Vec<u32>,
    /// The tree of the faces, which moves with them.
    tree: TriangleTree,
    /// The face that each sample of the input was nearest to last.
    hints: Vec<u32>,
    /// The input triangle that each point of the level's faces was nearest to last, in the order of
    /// the tree.
    backward_hints: Vec<u32>,
    /// The squared distances of each sample that has a hint, as [`Found`] has them.
    squared: Vec<[f64; 2]>,
    /// Those of each point that has a backward hint.
    backward_squared: Vec<[f64; 2]>,
    /// The mean normal of the input near each face.
    input_normals: Vec<DVec3>,
    /// Where the points were when samples were looked up last; empty before the first
    /// [`Purpose::Solve`].
    looked_up_at: Vec<DVec3>,
    /// How far from a sample its own sheet is looked for at least: the mean edge of the level.
    reach: f64,
}

/// What the ties at a state of the points are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Purpose {
    /// To move the points.
    Solve,
    /// To know how far the surfaces are from each other, at most: samples whose face has not moved
    /// since they were looked up stay tied to it.
    Measure,
}

/// The ties between both surfaces at one state of the points.
struct Ties<'a> {
    /// None where nothing is to be solved.
    system: Option<System<'a>>,
    /// Mean squared distance, both directions added.
    energy: f64,
    face_distances: FaceDistances,
    /// The largest squared distance of a sample from any sheet.
    max_squared: f64,
}

/// A tie with its squared length, and that to the nearest point of any sheet.
type Found = (Tie, [f64; 2]);

/// Positions of the points, and how far both surfaces are from each other then.
struct State {
    positions: Vec<DVec3>,
    energy: f64,
    face_distances: FaceDistances,
    energies_around: Vec<f64>,
}

/// Distances of the level where the simplifier left it.
struct UnmovedDistances {
    /// Mean squared distance, both directions added.
    energy: f64,
    /// The same around each point.
    energies_around: Vec<f64>,
    /// The most that the squared distance of any sample may become.
    max_squared: f64,
}

impl UnmovedDistances {
    /// Holds the points that have got worse, if together they raise the energy by more than
    /// [`MAX_WORSE_SHARE`]; returns whether any was not held before.
    fn hold_worse(&self, energies_around: &[f64], held: &mut [bool]) -> bool {
        let excess = |p: usize| energies_around[p] - self.energies_around[p];
        let total_excess: f64 = (0..held.len()).map(|p| excess(p).max(0.0)).sum();
        if total_excess <= MAX_WORSE_SHARE * self.energies_around.iter().sum::<f64>() {
            return false;
        }
        let mut any_new = false;
        for p in (0..held.len()).filter(|&p| excess(p) > 0.0) {
            any_new |= !held[p];
            held[p] = true;
        }
        any_new
    }
}

impl Ties<'_> {
    /// Adds a tie of a sample.
    fn add(&mut self, (tie, squared): &Found) {
        if let Some(system) = &mut self.system {
            system.add(tie);
        }
        self.add_distances(tie.face, tie.weight, *squared);
    }

    /// Adds the distances of a sample that is tied to a face.
    fn add_distances(&mut self, face: u32, weight: f64, [squared, to_any]: [f64; 2]) {
        self.energy += weight * squared;
        self.face_distances.add(face, weight, squared);
        self.max_squared = self.max_squared.max(to_any);
    }
}

impl<'a> Fit<'a> {
    fn new(input: &'a Input, level: &'a CoarseMesh) -> Self {
        let charts = level.input_triangles.iter().map(|&t| input.charts[t as usize]);
        let charts: Vec<u32> = charts.collect();
        let normal = |corners| cross(corners).normalize_or_zero();
        let corners = level.corners(&level.points);
        let reach = mean_edge(&corners);
        let tree = TriangleTree::new(&corners);
        // A face is near the triangle that it was.
        let hint = |&face: &u32| {
            std::iter::repeat_n(level.input_triangles[face as usize], input.level_rule.len())
        };
        let backward_hints: Vec<u32> = tree.spatial_order().iter().flat_map(hint).collect();
        Self {
            input,
            level,
            first_normals: corners.into_iter().map(normal).collect(),
            first_edge_lengths: level.edge_lengths(&level.points),
            curves: curves(&level.faces, &charts),
            hints: level.first_hints(input),
            squared: vec![[0.0; 2]; input.sample_count()],
            backward_squared: vec![[0.0; 2]; backward_hints.len()],
            backward_hints,
            input_normals: vec![DVec3::ZERO; level.faces.len()],
            looked_up_at: Vec::new(),
            tree,
            reach,
        }
    }

    /// Returns the best positions of the points that `iterations` find, and the distance of the
    /// sample that was farthest at the start.
    fn run(&mut self, iterations: u32, tick: &(dyn Fn() + Sync)) -> (Vec<DVec3>, f64) {
        let start = self.tie(&self.level.points, Purpose::Solve);
        let first_distance = start.max_squared.sqrt();
        (self.best(start, iterations, tick), first_distance)
    }

    fn best(&mut self, start: Ties<'a>, iterations: u32, tick: &(dyn Fn() + Sync)) -> Vec<DVec3> {
        let (points, faces) = (&self.level.points, &self.level.faces);
        let reach = self.reach.min(MAX_RATIO * start.max_squared.sqrt());
        let neighbours = Neighbours::new(self.input, self.level, &self.tree, reach);
        let max_squared = MAX_RATIO * MAX_RATIO * start.face_distances.max_squared();
        let first = UnmovedDistances {
            energy: start.energy,
            energies_around: self.energies_around(&start.face_distances),
            max_squared,
        };
        let (mut best, mut positions) = (None, points.clone());
        let (mut least_energy, mut ties) = (first.energies_around.iter().sum(), start);
        for left in (0..iterations).rev() {
            tick();
            if ties.energy.sqrt() < GOOD_ENOUGH_SHARE * self.input.diagonal {
                break;
            }
            let Some(system) = ties.system.take() else { break };
            let moves = self.clamped(&positions, &system.solve(&self.level.locked));
            positions = self.guard().limit(&positions, &moves);
            let purpose = if left > 0 { Purpose::Solve } else { Purpose::Measure };
            ties = self.tie(&positions, purpose);
            let energies_around = self.energies_around(&ties.face_distances);
            let reachable = energy_if_worse_stay(&first.energies_around, &energies_around);
            if reachable < least_energy {
                least_energy = reachable;
                let (positions, face_distances) = (positions.clone(), ties.face_distances.clone());
                let energy = ties.energy;
                best = Some(State { positions, energy, face_distances, energies_around });
            }
        }
        let Some(best) = best else { return points.clone() };
        let mut held = barely_closer(&first.energies_around, &best.energies_around, faces);
        self.tree.move_to(&self.level.corners(&best.positions));
        let crossed = neighbours.crossed(self.level, &self.tree, &best.positions);
        let is_good = best.energy < first.energy
            && best.face_distances.max_squared() <= max_squared
            && crossed.is_empty()
            && !held.contains(&true);
        if !first.hold_worse(&best.energies_around, &mut held) && is_good {
            return best.positions;
        }
        let (held_back, ties) = self.hold_back(&best, held, crossed, (&first, &neighbours));
        let max_energy = if is_good { best.energy } else { first.energy };
        if ties.energy < max_energy && ties.face_distances.max_squared() <= max_squared {
            held_back
        } else if is_good {
            best.positions
        } else {
            self.level.points.clone()
        }
    }

    fn energies_around(&self, face_distances: &FaceDistances) -> Vec<f64> {
        face_distances.energies_around(&self.level.faces, self.level.points.len())
    }

    /// Returns the positions of `best` with points back where the simplifier left them: those that
    /// are `held`, the corners of faces with a sample beyond the limit, with one more ring of
    /// neighbours in each round, points that get worse, and corners of faces that have `crossed`
    /// others. Ends when no sample is beyond the limit, no face has crossed another, and hardly any
    /// point is worse. The ties there come with them.
    fn hold_back(
        &mut self,
        best: &State,
        mut held: Vec<bool>,
        mut crossed: Vec<usize>,
        (first, neighbours): (&UnmovedDistances, &Neighbours),
    ) -> (Vec<DVec3>, Ties<'a>) {
        let (level, moved) = (self.level, &best.positions);
        let mut beyond_limit = vec![false; moved.len()];
        let mut last: Option<(Vec<DVec3>, Ties<'a>)> = None;
        for _ in 0..MAX_HOLD_ROUNDS {
            let distances = last.as_ref().map_or(&best.face_distances, |(_, t)| &t.face_distances);
            let is_affected = |f: &usize| {
                let is_beyond = |&p: &u32| beyond_limit[p as usize];
                distances.max_squared_of(*f) > first.max_squared
                    || level.faces[*f].iter().any(is_beyond)
            };
            let affected_faces: Vec<usize> =
                (0..level.faces.len()).filter(is_affected).chain(crossed.drain(..)).collect();
            for &p in affected_faces.iter().flat_map(|&f| &level.faces[f]) {
                beyond_limit[p as usize] = true;
                held[p as usize] = true;
            }
            let moves: Vec<DVec3> = (0..moved.len())
                .map(|p| if held[p] { DVec3::ZERO } else { moved[p] - level.points[p] })
                .collect();
            let positions = self.guard().limit(&level.points, &moves);
            let ties = self.tie(&positions, Purpose::Measure);
            let got_worse =
                first.hold_worse(&self.energies_around(&ties.face_distances), &mut held);
            crossed = neighbours.crossed(level, &self.tree, &positions);
            let is_done = ties.face_distances.max_squared() <= first.max_squared
                && crossed.is_empty()
                && !got_worse;
            last = Some((positions, ties));
            if is_done {
                break;
            }
        }
        last.expect("a round")
    }

    fn guard(&self) -> Guard<'_> {
        let (first_normals, input_normals) = (&self.first_normals, &self.input_normals);
        Guard { level: self.level, first_normals, input_normals }
    }

    /// Limits moves to [`MAX_STEP`], and to [`MAX_MOVE`] in all.
    fn clamped(&self, positions: &[DVec3], moves: &[DVec3]) -> Vec<DVec3> {
        let lengths = self.level.edge_lengths(positions);
        (0..positions.len())
            .map(|i| {
                let step = moves[i].clamp_length_max(MAX_STEP * lengths[i]);
                let first = self.level.points[i];
                let total = positions[i] + step - first;
                first + total.clamp_length_max(MAX_MOVE * self.first_edge_lengths[i]) - positions[i]
            })
            .map(|m| if m.is_finite() { m } else { DVec3::ZERO })
            .collect()
    }

    /// Ties both surfaces to each other, with the points of the level at `positions`.
    fn tie(&mut self, positions: &[DVec3], purpose: Purpose) -> Ties<'a> {
        let corners = self.level.corners(positions);
        self.tree.move_to(&corners);
        let crosses: Vec<DVec3> = corners.iter().map(|&t| cross(t)).collect();
        let level = self.level;
        let system = (purpose == Purpose::Solve)
            .then(|| System::new(positions.len(), &level.faces, &level.face_edges, &level.edges));
        let face_distances = FaceDistances::new(level.faces.len());
        let mut ties = Ties { system, energy: 0.0, face_distances, max_squared: 0.0 };
        let stayed = match purpose {
            Purpose::Solve => vec![false; level.faces.len()],
            Purpose::Measure => stayed(level, &self.looked_up_at, positions),
        };
        self.tie_input(&corners, &crosses, &stayed, &mut ties);
        self.tie_level(&corners, &crosses, &stayed, &mut ties);
        if let Some(system) = &mut ties.system {
            self.tie_curves(&corners, system);
        }
        self.looked_up_at.clear();
        self.looked_up_at.extend_from_slice(positions);
        ties
    }

    /// Ties the input's samples to the level. `crosses` are twice the areas of faces along their
    /// normals; samples stay tied to faces that have `stayed`.
    fn tie_input(
        &mut self,
        corners: &[[DVec3; 3]],
        crosses: &[DVec3],
        stayed: &[bool],
        ties: &mut Ties<'_>,
    ) {
        let (input, level, tree, reach) = (self.input, self.level, &self.tree, self.reach);
        let face_sheet = |face: usize| Sheet {
            component: input.components[level.input_triangles[face] as usize],
            normal: crosses[face],
        };
        let tiny_squared = (TINY_SHARE * input.diagonal).powi(2);
        let blocks = self.hints.chunks_mut(SAMPLES_PER_BLOCK);
        let squared = self.squared.chunks_mut(SAMPLES_PER_BLOCK);
        for (block, (hints, squared)) in blocks.zip(squared).enumerate() {
            let tie_sample = |i: usize, hint: u32| {
                let (triangle, barycentric, weight) = input.sample_location(i);
                let p = input.surface_point(triangle, barycentric);
                let sheet = input.sheet(triangle);
                let is_own = |face: u32| sheet.goes_with(face_sheet(face as usize));
                let (nearest, to_any) = nearest_of_sheet(tree, p, hint, reach, is_own)?;
                let face = nearest.triangle as usize;
                let residual = point_at(corners[face], nearest.barycentric) - p;
                let normal = crosses[face].normalize_or_zero();
                let direction = direction(residual, nearest.squared, tiny_squared, normal);
                let tie = Tie {
                    face: nearest.triangle,
                    barycentric: nearest.barycentric,
                    residual,
                    direction,
                    weight,
                };
                Some((tie, [nearest.squared, to_any]))
            };
            type Run<'r> = (&'r mut [u32], &'r mut [[f64; 2]]);
            let tie_run = |(run, (hints, squared)): (usize, Run<'_>)| -> Vec<Found> {
                let first_sample = SAMPLES_PER_BLOCK * block + SAMPLES_PER_THREAD * run;
                let mut last_face = NONE;
                let tie_next = |(i, (hint, squared)): (usize, (&mut u32, &mut [f64; 2]))| {
                    if *hint != NONE && stayed[*hint as usize] {
                        let weight = input.sample_location(first_sample + i).2;
                        return Some((Tie::of_face(*hint, weight), *squared));
                    }
                    let guess = if *hint == NONE { last_face } else { *hint };
                    let tie = tie_sample(first_sample + i, guess);
                    *hint = tie.map_or(NONE, |(tie, _)| tie.face);
                    *squared = tie.map_or([0.0; 2], |(_, squared)| squared);
                    last_face = *hint;
                    tie
                };
                hints.iter_mut().zip(squared).enumerate().filter_map(tie_next).collect()
            };
            let runs = hints.par_chunks_mut(SAMPLES_PER_THREAD);
            let runs = runs.zip(squared.par_chunks_mut(SAMPLES_PER_THREAD));
            let found: Vec<_> = runs.enumerate().map(tie_run).collect();
            found.iter().flatten().for_each(|tie| ties.add(tie));
        }
    }

    /// Ties points on the level's faces to the input, and finds the input's normals there. Those of
    /// faces that have `stayed` are as they were.
    fn tie_level(
        &mut self,
        corners: &[[DVec3; 3]],
        crosses: &[DVec3],
        stayed: &[bool],
        ties: &mut Ties<'_>,
    ) {
        let (input, level, reach) = (self.input, self.level, self.reach);
        let tiny_squared = (TINY_SHARE * input.diagonal).powi(2);
        let area = crosses.iter().map(|c| c.length()).sum::<f64>().max(f64::MIN_POSITIVE);
        type Points<'p> = (&'p mut [u32], &'p mut [[f64; 2]]);
        let tie_face = |(face, (hints, squared)): (&u32, Points<'_>)| {
            let (face, mut normal) = (*face as usize, DVec3::ZERO);
            let mut found = [None; MAX_POINTS];
            let weight = |share: f64| crosses[face].length() * share / area;
            if stayed[face] {
                for (k, (_, share)) in input.level_rule.iter().enumerate() {
                    let kept = (Tie::of_face(face as u32, weight(*share)), squared[k]);
                    found[k] = (hints[k] != NONE).then_some(kept);
                }
                return (found, None);
            }
            let component = input.components[level.input_triangles[face] as usize];
            let sheet = Sheet { component, normal: crosses[face] };
            for (k, (barycentric, share)) in input.level_rule.iter().enumerate() {
                let q = point_at(corners[face], *barycentric);
                let hint = if hints[k] == NONE { hints[k.saturating_sub(1)] } else { hints[k] };
                let is_own = |triangle: u32| sheet.goes_with(input.sheet(triangle as usize));
                let found_nearest = nearest_of_sheet(&input.tree, q, hint, reach, is_own);
                let Some((nearest, to_any)) = found_nearest else { continue };
                hints[k] = nearest.triangle;
                squared[k] = [nearest.squared, to_any];
                let input_triangle = nearest.triangle as usize;
                normal += input.normals[input_triangle] * *share;
                let residual = q - input.surface_point(input_triangle, nearest.barycentric);
                let direction = direction(
                    residual,
                    nearest.squared,
                    tiny_squared,
                    input.normals[input_triangle],
                );
                let (face, barycentric, weight) = (face as u32, *barycentric, weight(*share));
                let tie = Tie { face, barycentric, residual, direction, weight };
                found[k] = Some((tie, squared[k]));
            }
            (found, Some(normal.normalize_or_zero()))
        };
        let per_face = input.level_rule.len();
        let hints = self.backward_hints.chunks_mut(SAMPLES_PER_BLOCK * per_face);
        let squared = self.backward_squared.chunks_mut(SAMPLES_PER_BLOCK * per_face);
        let blocks = self.tree.spatial_order().chunks(SAMPLES_PER_BLOCK).zip(hints.zip(squared));
        for (faces, (hints, squared)) in blocks {
            let points = hints.par_chunks_mut(per_face).zip(squared.par_chunks_mut(per_face));
            let found: Vec<_> = faces.par_iter().zip(points).map(tie_face).collect();
            for (&face, (points, normal)) in faces.iter().zip(found) {
                if let Some(normal) = normal {
                    self.input_normals[face as usize] = normal;
                }
                points.iter().flatten().for_each(|found| ties.add(found));
            }
        }
    }

    /// Ties the curves of both surfaces to each other: borders, borders of materials, seams of
    /// charts.
    fn tie_curves(&self, corners: &[[DVec3; 3]], system: &mut System<'_>) {
        let (input, curves) = (self.input, &self.curves);
        if curves.is_empty() || input.curve_points.is_empty() {
            return;
        }
        let ends = |side: u32| {
            let (t, k) = (corners[side as usize / 3], side as usize % 3);
            [t[k], t[(k + 1) % 3]]
        };
        let segments: Vec<[DVec3; 2]> = curves.iter().map(|&side| ends(side)).collect();
        let lengths: Vec<f64> = segments.iter().map(|[a, b]| a.distance(*b)).collect();
        // A curve weighs as much as a band along it, as wide as a mean edge is long.
        let weight_per_length = mean_edge(corners) / input.area.max(f64::MIN_POSITIVE);
        let tree = TriangleTree::of_segments(&segments);
        let tie = |segment: usize, t: f64, residual: DVec3, weight: f64| {
            let (side, mut barycentric) = (curves[segment], [0.0; 3]);
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
                    Some(tie(segment, t, a.lerp(b, t) - p, length * weight_per_length))
                })
                .collect();
        let from_level: Vec<Option<Tie>> = (0..POINTS_PER_CURVE_EDGE * segments.len())
            .into_par_iter()
            .map(|i| {
                let (segment, k) = (i / POINTS_PER_CURVE_EDGE, i % POINTS_PER_CURVE_EDGE);
                let t = (k as f64 + 0.5) / POINTS_PER_CURVE_EDGE as f64;
                let q = segments[segment][0].lerp(segments[segment][1], t);
                let found = input.curve_tree.nearest(q, NONE)?;
                let p = input.point_on_curve(found.triangle as usize, 1.0 - found.barycentric[0]);
                Some(tie(
                    segment,
                    t,
                    q - p,
                    lengths[segment] / POINTS_PER_CURVE_EDGE as f64 * weight_per_length,
                ))
            })
            .collect();
        from_input.into_iter().chain(from_level).flatten().for_each(|tie| system.add(&tie));
    }
}

/// The mean length of the sides of triangles.
fn mean_edge(corners: &[[DVec3; 3]]) -> f64 {
    let perimeter = |[a, b, c]: &[DVec3; 3]| a.distance(*b) + b.distance(*c) + c.distance(*a);
    corners.iter().map(perimeter).sum::<f64>() / (3 * corners.len()).max(1) as f64
}

/// The unit direction of a residual, or the normal where it is too short to have one.
fn direction(residual: DVec3, squared: f64, tiny_squared: f64, normal: DVec3) -> DVec3 {
    if squared < tiny_squared { normal } else { residual / squared.sqrt() }
}
