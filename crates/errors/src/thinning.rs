//! Thinning: the samples that stay on a face that has many.
//!
//! The distance to a triangle is convex, so the farthest of some points is a corner of their convex
//! hull. Where a face may decide the bound, the ones farthest in many directions stay: however many
//! faces become one, no sample that reaches beyond all others in one of them is lost.

use crate::faces::Face;
use crate::samples::{Sample, Samples};
use glam::DVec3;
use lodc_mesh::NONE;

/// Samples that a face keeps once it has half as many more. Alone, 16 are not enough (1.07 stated,
/// 1.41 measured on a cone of 100,000 needles): hence the outermost ones below.
const KEPT: usize = 16;
/// The most that it keeps, where few faces are left. Chosen by hand.
const MOST_KEPT: usize = 256;

/// Share of the squared bound beyond which a face keeps the outermost samples, too, unless it keeps
/// as many anyway: half the distance. Chosen by hand, as is the next.
const HOT: f64 = 0.25;

/// The same for the area that belongs to its samples, as a multiple of a mean face's.
const LARGE: f64 = 8.0;

/// Directions in which samples are outermost: neighbouring ones are 30° apart, so what lies beyond
/// all that stay is beyond them by a few hundredths of the face's extent. Not tuned.
const DIRECTIONS: usize = 48;

/// Cosine and sine of the golden angle.
const GOLDEN: [f64; 2] = [-0.737_368_878_078_319_7, 0.675_490_294_261_523_8];

/// Directions that are spread evenly, and buffers that are used again for each face.
pub(crate) struct Thinning {
    /// Samples that all faces keep together where few are left.
    kept_in_all: usize,
    directions: Vec<DVec3>,
    /// The samples of the face.
    all: Vec<u32>,
    /// Indices in `all` of samples that are outermost.
    outer: Vec<usize>,
    /// Those of them that stay.
    kept: Vec<u32>,
    /// The squared distance of each sample to the nearest one kept, and its index in `kept`; -1
    /// for one that is kept.
    nearest_kept: Vec<(f64, u32)>,
}

impl Thinning {
    /// `kept_in_all` is the number of samples that faces keep together where few are left.
    pub(crate) fn new(kept_in_all: usize) -> Self {
        // Points on a spiral from pole to pole (as Swinbank and Purser 2006 place them).
        let mut turn = [1.0, 0.0];
        let point = |i: usize| {
            let ([x, y], [c, s]) = (turn, GOLDEN);
            turn = [x * c - y * s, x * s + y * c];
            let z = (2 * i + 1) as f64 / DIRECTIONS as f64 - 1.0;
            let radius = (1.0 - z * z).sqrt();
            DVec3::new(radius * x, radius * y, z)
        };
        Self {
            kept_in_all,
            directions: (0..DIRECTIONS).map(point).collect(),
            all: vec![],
            outer: vec![],
            kept: vec![],
            nearest_kept: vec![],
        }
    }

    /// Leaves a face that has many samples the farthest, others far from each other, and the
    /// outermost ones where it may decide the squared `bound`. The ones that stay take over the
    /// area of those that go. `live` is the number of faces that are left.
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
        for (&gone, &(apart, number)) in self.all.iter().zip(&self.nearest_kept) {
            if apart >= 0.0 {
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
        let Self { all, kept, nearest_kept, .. } = self;
        let farther = |&a: &usize, &b: &usize| {
            let key = |i: usize| samples[all[i] as usize].squared;
            key(a).total_cmp(&key(b)).then(all[b].cmp(&all[a]))
        };
        let mut choice = (0..all.len()).max_by(farther).expect("there are many");
        kept.clear();
        nearest_kept.clear();
        nearest_kept.resize(all.len(), (f64::INFINITY, 0));
        self.outer.clear();
        if outer {
            self.find_outermost(samples);
            self.outer.retain(|&i| i != choice);
        }
        let Self { all, kept, nearest_kept, outer, .. } = self;
        let keep = keep + outer.len();
        while kept.len() < keep {
            let number = kept.len() as u32;
            kept.push(all[choice]);
            let place = samples[all[choice] as usize].place();
            nearest_kept[choice].0 = -1.0;
            let mut far = (-1.0, choice);
            for (i, nearest) in nearest_kept.iter_mut().enumerate() {
                let apart = (samples[all[i] as usize].place() - place).length_squared();
                if apart < nearest.0 {
                    *nearest = (apart, number);
                }
                if nearest.0 > far.0 {
                    far = (nearest.0, i);
                }
            }
            choice = outer.pop().unwrap_or(far.1);
        }
    }

    /// Notes the samples that are outermost in one of the directions, each once.
    fn find_outermost(&mut self, samples: &[Sample]) {
        let Self { directions, all, outer, .. } = self;
        for &direction in &*directions {
            let mut most = (f64::NEG_INFINITY, 0);
            for (i, &sample) in all.iter().enumerate() {
                let height = samples[sample as usize].place().dot(direction);
                if height > most.0 {
                    most = (height, i);
                }
            }
            outer.push(most.1);
        }
        outer.sort_unstable();
        outer.dedup();
    }
}

/// Returns whether a face may decide the squared `bound`, and has come from so large an area that a
/// few samples do not tell its shape.
fn is_hot(samples: &Samples, face: &Face, live: u32, bound: f64) -> bool {
    let (mut far, mut weight) = (0.0f32, 0.0);
    for sample in samples.of(face).map(|s| &samples.all[s as usize]) {
        far = far.max(sample.squared);
        weight += f64::from(sample.weight);
    }
    f64::from(far) > HOT * bound && weight * f64::from(live) > LARGE * samples.weight
}
