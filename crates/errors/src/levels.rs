//! Levels that are measured as surfaces, each by itself: from nothing but their triangles.

use crate::Tick;
use crate::input::Input;
use crate::step_errors::above;
use glam::DVec3;
use lodc_mesh::{Lod, NONE, Simplified, SplitMix64, is_degenerate};
use lodc_nearest::{Moving, MovingTree, Search, Surface, Triangles, area, morton_order, point_at};
use rayon::prelude::*;

/// Points on either surface that the mean is of, at least: it is known to about a hundredth.
const POINTS: f64 = 4_096.0;

/// Points that one thread looks up one after the other.
const RUN: usize = 256;

/// Boxes that the search for one of them may open.
const PATIENCE: u32 = 1_024;

/// Most parts along an edge of a triangle, each with a point.
const MOST: f64 = 200.0;

/// Boxes that may be opened for each triangle and besides, where one level is measured.
const BOXES: [u32; 2] = [500, 1_000_000];

/// How far a level is from LOD 0, in the mesh's units; infinite where a mesh that had triangles has
/// none left.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelError {
    /// An upper bound of the Hausdorff distance between both surfaces, about 2 % above it.
    pub error: f32,
    /// The root mean square distance over the area, the larger of both ways, from samples.
    pub rms: f32,
}

/// Measures some levels of a sequence, each by itself, without those before it: the largest over
/// all `shapes`, each a place for every vertex. A level may be less far than a finer one, and than
/// [`measure`](crate::measure) states of it, which never falls.
///
/// All threads share the work; the result is the same with any number.
///
/// # Panics
/// If there are not as many places as vertices in a shape.
#[must_use]
pub fn at_levels<S: AsRef<[[f32; 3]]>>(
    simplified: &Simplified,
    shapes: impl IntoIterator<Item = S>,
    lods: &[Lod],
    tick: &Tick<'_>,
) -> Vec<LevelError> {
    let mut errors = vec![LevelError::default(); lods.len()];
    for shape in shapes {
        let shown = shape.as_ref();
        assert_eq!(shown.len(), simplified.mesh().vertex_count(), "a place for each vertex");
        let (input, wedges) = Input::new(simplified, shown);
        let search = Search { boxes: BOXES, ..Search::within(input.diagonal) };
        let original = Original { input: &input, simplified, wedges: &wedges, search };
        for (level, &lod) in errors.iter_mut().zip(lods) {
            tick();
            let before = f64::from(level.error) / input.unit;
            let ([error, rms], _) = original.measure(lod, before);
            let [error, rms] = [error, rms].map(|distance| above(distance * input.unit));
            *level = LevelError { error: level.error.max(error), rms: level.rms.max(rms) };
        }
    }
    errors
}

/// LOD 0, ready for levels to be measured from it.
pub(crate) struct Original<'a> {
    pub(crate) input: &'a Input,
    pub(crate) simplified: &'a Simplified,
    /// The corners of the input's triangles as vertices of the mesh.
    pub(crate) wedges: &'a [[u32; 3]],
    pub(crate) search: Search,
}

impl Original<'_> {
    /// Measures a level: an upper bound of its distance and the root mean square distance, in units
    /// of the input's places, and the boxes that were opened. What is nearer than `before` is not
    /// looked at closely.
    pub(crate) fn measure(&self, lod: Lod, before: f64) -> ([f64; 2], u64) {
        let Self { input, simplified, wedges, search } = self;
        let map = simplified.collapses().resolve_all(lod);
        let mut level = Level { input, faces: vec![] };
        let (mut from, mut back) = (Changed::default(), Changed::default());
        for (old, wedges) in input.triangles.iter().zip(*wedges) {
            let new = wedges.map(|v| input.point_of[map[v as usize] as usize]);
            let is_live = !is_degenerate(new.map(|p| input.positions[p as usize]));
            if is_live {
                level.faces.push(new);
            }
            from.add(input.at(*old), *old != new);
            if is_live {
                back.add(input.at(new), *old != new);
            }
        }
        if level.faces.is_empty() {
            return ([if input.triangles.is_empty() { 0.0 } else { f64::INFINITY }; 2], 0);
        }
        if from.triangles.is_empty() {
            return ([0.0; 2], 0);
        }
        let places = |t: u32| level.faces[t as usize].map(|p| input.places[p as usize]);
        let order = morton_order(0..level.faces.len() as u32, places);
        level.faces = order.iter().map(|&t| level.faces[t as usize]).collect();
        let places = |t: u32| level.faces[t as usize].map(|p| input.places[p as usize]);
        let tree = MovingTree::of_all(level.faces.len() as u32, places);
        let level = Moving { triangles: &level, tree: &tree };
        let original = Moving { triangles: *input, tree: &input.tree };

        let (there, here) = rayon::join(|| from.sample(&level), || back.sample(&original));
        // A sample is a point that is so far off.
        let known = there.far.max(here.far).max(before / (1.0 + search.tolerance));
        let (forth, back) = rayon::join(
            || search.beyond(known, &from.triangles, &level),
            || search.beyond(known, &back.triangles, &original),
        );
        let error = forth.most.max(back.most).min(input.diagonal);
        let rms = there.mean_square.max(here.mean_square).sqrt().min(error);
        ([error, rms], forth.opened + back.opened)
    }
}

/// A level as its tree sees it.
struct Level<'a> {
    input: &'a Input,
    faces: Vec<[u32; 3]>,
}

impl Triangles for Level<'_> {
    #[inline]
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.input.at(self.faces[triangle as usize])
    }
    #[inline]
    fn is_live(&self, _: u32) -> bool {
        true
    }
}

/// The triangles of one surface that the other has not, and the area of all.
#[derive(Default)]
struct Changed {
    triangles: Vec<[DVec3; 3]>,
    area: f64,
}

/// What samples have found.
struct Sampled {
    mean_square: f64,
    /// The largest distance that is sure.
    far: f64,
}

impl Changed {
    fn add(&mut self, corners: [DVec3; 3], is_changed: bool) {
        self.area += area(corners);
        if is_changed {
            self.triangles.push(corners);
        }
    }

    /// Samples the distance to a surface: a point anywhere in each of equal parts of a triangle, as
    /// many as its share of the area asks for; of many triangles in some.
    fn sample(&self, to: &(impl Surface + Sync)) -> Sampled {
        let stride = ((self.triangles.len() as f64 / POINTS) as usize).max(1);
        let count = self.triangles.len().div_ceil(stride);
        let starts: Vec<usize> = (0..count).step_by(RUN).collect();
        let run = |start: usize| {
            let mut random = SplitMix64::new(start as u64);
            let (mut near, mut sum, mut weight, mut far) = (NONE, 0.0, 0.0, 0.0f64);
            for i in start..(start + RUN).min(count) {
                // One of the next `stride` triangles.
                let many = stride.min(self.triangles.len() - i * stride);
                let corners = self.triangles[i * stride + random.below(many)];
                let share = area(corners) * many as f64;
                let n = (share / self.area * POINTS).sqrt().ceil().clamp(1.0, MOST);
                let part = share / (n * n);
                for (row, column) in rows(n as u32) {
                    let p = point_at(corners, within(n, row, column, &mut random));
                    let (hit, opened) = to.near(p, near, 0.0, PATIENCE);
                    near = hit.triangle;
                    sum += hit.squared * part;
                    far = far.max(if opened < PATIENCE { hit.squared } else { 0.0 });
                }
                weight += share;
            }
            (sum, weight, far)
        };
        let runs: Vec<_> = starts.into_par_iter().map(run).collect();
        let (sum, weight, far) = runs
            .iter()
            .fold((0.0, 0.0, 0.0f64), |all, run| (all.0 + run.0, all.1 + run.1, all.2.max(run.2)));
        let changed: f64 = self.triangles.iter().map(|&t| area(t)).sum();
        let mean = if weight > 0.0 { sum / weight } else { 0.0 };
        let share = if self.area > 0.0 { changed / self.area } else { 0.0 };
        Sampled { mean_square: mean * share, far: far.sqrt() }
    }
}

/// The parts of a triangle that is divided `n` times each way: rows, and in each the upright and
/// the turned parts in turn.
fn rows(n: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..n).flat_map(move |row| (0..2 * (n - row) - 1).map(move |column| (row, column)))
}

/// Barycentric coordinates of a point anywhere in a part of a triangle.
fn within(n: f64, row: u32, column: u32, random: &mut SplitMix64) -> [f64; 3] {
    let [mut u, mut v] = [0; 2].map(|_| f64::from(random.unit()));
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    if column % 2 == 1 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    let (u, v) = ((f64::from(row) + u) / n, (f64::from(column / 2) + v) / n);
    [u, v, 1.0 - u - v]
}
