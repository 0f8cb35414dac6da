//! Thinning: the samples that stay on a face that has many.
//!
//! The distance to a triangle is convex, so the farthest of some points is a corner of their convex
//! hull. Where a face may decide the bound, the ones farthest in many directions stay: however many
//! faces become one, no sample that reaches beyond all others in one of them is lost.

use crate::faces::Face;
use crate::samples::{Sample, Samples};
use lodc_mesh::NONE;

/// Samples that a face keeps when it has half as many more, unless few faces are left.
const KEPT: usize = 16;
const MOST_KEPT: usize = 256;

/// Share of the squared bound beyond which a face keeps the outermost samples, too, unless it keeps
/// as many anyway.
const HOT: f64 = 0.25;

/// The same for the area that its samples stand for, as a multiple of that of a mean face.
const LARGE: f64 = 8.0;

/// Directions in which samples are outermost.
const DIRECTIONS: usize = 48;

/// Samples that are looked at at once.
const LANES: usize = 4;

/// Stands for a squared distance where a sample is kept.
const KEPT_ITSELF: f64 = -1.0;

/// Cosine and sine of the golden angle.
const GOLDEN: [f64; 2] = [-0.737_368_878_078_319_7, 0.675_490_294_261_523_8];

/// Directions that are spread evenly, and room for thinning.
pub(crate) struct Thinning {
    /// Samples that all faces keep together where few are left.
    kept_in_all: usize,
    /// By axis.
    directions: [[f64; DIRECTIONS]; 3],
    all: Vec<u32>,
    /// Places in `all` of samples that are outermost.
    outer: Vec<usize>,
    kept: Vec<u32>,
    /// The places of all samples by axis, [`LANES`] at a time.
    places: [Vec<f64>; 3],
    /// The squared distance of each sample to the nearest one kept, [`KEPT_ITSELF`] of one that is,
    /// and the place of that one in `kept`.
    apart: Vec<f64>,
    nearest: Vec<u64>,
}

impl Thinning {
    /// Faces keep so many samples together where few of them are left.
    pub(crate) fn new(kept_in_all: usize) -> Self {
        // Points on a spiral from pole to pole (as Swinbank and Purser 2006 place them).
        let mut turn = [1.0, 0.0];
        let point = |i: usize| {
            let ([x, y], [c, s]) = (turn, GOLDEN);
            turn = [x * c - y * s, x * s + y * c];
            let z = (2 * i + 1) as f64 / DIRECTIONS as f64 - 1.0;
            let radius = (1.0 - z * z).sqrt();
            [radius * x, radius * y, z]
        };
        let points: Vec<[f64; 3]> = (0..DIRECTIONS).map(point).collect();
        let directions = [0, 1, 2].map(|axis| std::array::from_fn(|k| points[k][axis]));
        Self {
            kept_in_all,
            directions,
            all: vec![],
            outer: vec![],
            kept: vec![],
            places: Default::default(),
            apart: vec![],
            nearest: vec![],
        }
    }

    /// Leaves a face that has many samples the farthest, others far from each other, and the
    /// outermost ones where it may decide the squared `bound`. The ones that stay stand for the
    /// area of those that go. `live` faces are left.
    pub(crate) fn thin(
        &mut self,
        samples: &mut Samples,
        faces: &mut [Face],
        face: u32,
        live: u32,
        bound: f64,
    ) {
        let keep = (self.kept_in_all / live.max(1) as usize).clamp(KEPT, MOST_KEPT);
        let count = faces[face as usize].samples as usize;
        if count <= keep + keep / 2 {
            return;
        }
        let outer = keep < KEPT + DIRECTIONS && is_hot(samples, &faces[face as usize], live, bound);
        if outer && count <= (keep + DIRECTIONS) * 3 / 2 {
            return;
        }
        self.all.clear();
        self.all.extend(samples.of(&faces[face as usize]));
        self.choose(&samples.all, keep, outer);
        for (&gone, (&apart, &number)) in self.all.iter().zip(self.apart.iter().zip(&self.nearest))
        {
            if apart != KEPT_ITSELF {
                let gone = samples.all[gone as usize].clone();
                let kept = &mut samples.all[self.kept[number as usize] as usize];
                kept.weight += gone.weight;
                samples.sum +=
                    f64::from(gone.weight) * (f64::from(kept.squared) - f64::from(gone.squared));
            }
        }
        faces[face as usize].first_sample = NONE;
        faces[face as usize].samples = 0;
        for &sample in &self.kept {
            samples.link(faces, face, sample);
        }
    }

    /// Chooses the farthest of some samples, the outermost ones if `outer`, and `keep` in all
    /// besides those, each as far as possible from all before it.
    fn choose(&mut self, samples: &[Sample], keep: usize, outer: bool) {
        self.read(samples);
        let all = &self.all;
        let farther = |&a: &usize, &b: &usize| {
            let key = |i: usize| samples[all[i] as usize].squared;
            key(a).total_cmp(&key(b)).then(all[b].cmp(&all[a]))
        };
        let mut choice = (0..all.len()).max_by(farther).expect("there are many");
        self.kept.clear();
        self.outer.clear();
        if outer {
            self.find_outermost();
            self.outer.retain(|&i| i != choice);
        }
        let keep = keep + self.outer.len();
        while self.kept.len() < keep {
            let farthest = self.keep(choice);
            choice = self.outer.pop().unwrap_or(farthest);
        }
    }

    /// Reads the places of all samples, none of which is kept yet.
    fn read(&mut self, samples: &[Sample]) {
        let Self { all, places, apart, nearest, .. } = self;
        let lanes = all.len().next_multiple_of(LANES);
        for (axis, places) in places.iter_mut().enumerate() {
            places.clear();
            places.extend(all.iter().map(|&s| samples[s as usize].place()[axis]));
            places.resize(lanes, 0.0);
        }
        nearest.clear();
        nearest.resize(lanes, 0);
        apart.clear();
        apart.resize(all.len(), f64::INFINITY);
        apart.resize(lanes, KEPT_ITSELF);
    }

    /// Keeps a sample. Returns the one that is farthest from all that are kept.
    fn keep(&mut self, choice: usize) -> usize {
        let Self { all, places: [xs, ys, zs], apart, nearest, kept, .. } = self;
        let number = kept.len() as u64;
        kept.push(all[choice]);
        apart[choice] = KEPT_ITSELF;
        let (x, y, z) = (xs[choice], ys[choice], zs[choice]);
        let mut most = [KEPT_ITSELF; LANES];
        let places = xs.chunks_exact(LANES).zip(ys.chunks_exact(LANES)).zip(zs.chunks_exact(LANES));
        let known = apart.chunks_exact_mut(LANES).zip(nearest.chunks_exact_mut(LANES));
        for ((apart, nearest), ((xs, ys), zs)) in known.zip(places) {
            for i in 0..LANES {
                let (dx, dy, dz) = (xs[i] - x, ys[i] - y, zs[i] - z);
                let squared = dx * dx + dy * dy + dz * dz;
                let is_nearer = squared < apart[i];
                nearest[i] = if is_nearer { number } else { nearest[i] };
                apart[i] = if is_nearer { squared } else { apart[i] };
                most[i] = if apart[i] > most[i] { apart[i] } else { most[i] };
            }
        }
        let most = most.into_iter().fold(KEPT_ITSELF, f64::max);
        let farthest =
            if most > KEPT_ITSELF { apart.iter().position(|&a| a == most) } else { None };
        farthest.unwrap_or(choice)
    }

    /// Notes the samples that are outermost in one of the directions, each once.
    fn find_outermost(&mut self) {
        let Self { directions: [xs, ys, zs], all, places, outer, .. } = self;
        let mut most = [f64::NEG_INFINITY; DIRECTIONS];
        let mut outermost = [0; DIRECTIONS];
        let [px, py, pz] = &*places;
        let places = px.iter().zip(py).zip(pz).take(all.len());
        for (i, ((&x, &y), &z)) in places.enumerate() {
            for k in 0..DIRECTIONS {
                let height = x * xs[k] + y * ys[k] + z * zs[k];
                let is_farther = height > most[k];
                most[k] = if is_farther { height } else { most[k] };
                outermost[k] = if is_farther { i } else { outermost[k] };
            }
        }
        outer.extend_from_slice(&outermost);
        outer.sort_unstable();
        outer.dedup();
    }
}

/// Returns whether a face may decide the squared `bound`, and stands for so much that a few samples
/// do not show its shape.
fn is_hot(samples: &Samples, face: &Face, live: u32, bound: f64) -> bool {
    let (mut far, mut weight) = (0.0f32, 0.0);
    for sample in samples.of(face).map(|s| &samples.all[s as usize]) {
        far = far.max(sample.squared);
        weight += f64::from(sample.weight);
    }
    f64::from(far) > HOT * bound && weight * f64::from(live) > LARGE * samples.weight
}
