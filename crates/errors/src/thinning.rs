//! Thinning: which samples a face with many of them keeps.
//!
//! The distance to a triangle is convex, so the farthest of some points is a corner of their convex
//! hull. Where a face may decide E, the largest distance so far, it also keeps the samples that are
//! outermost in many directions: however many faces become one, none of those is lost.

use crate::faces::Face;
use crate::samples::{Sample, Samples};
use glam::DVec3;
use lodc_mesh::NONE;

/// Samples that a face keeps, at least, once it has half as many more. Alone, 16 are not enough
/// (1.07 stated, 1.41 measured on a cone of 100,000 needles): hence the outermost ones below.
const MIN_KEPT: usize = 16;
/// The most that it keeps besides the outermost, where few faces are left. With 64, the mean
/// distance of the last two triangles of a height field of 288 is 15 % above the measured one; with
/// 128, 8 %.
const MAX_KEPT: usize = 128;

/// One in so many of those is the farthest from the face of those not kept yet. Chosen by hand.
const FARTHEST_DIVISOR: usize = 4;

/// A face keeps the outermost samples, too, if a squared distance is beyond this share of E² (half
/// of E), and the area of its samples is more than this many times a mean face's; unless it keeps
/// as many anyway. Chosen by hand.
const OUTERMOST_BEYOND: f64 = 0.25;
const OUTERMOST_AREA_RATIO: f64 = 8.0;

/// Directions in which samples are outermost: neighbouring ones are 30° apart, so what is beyond
/// all that are kept is beyond them by a few hundredths of the face's extent. Not tuned.
const DIRECTIONS: usize = 48;

/// Cosine and sine of the golden angle.
const GOLDEN_ANGLE: [f64; 2] = [-0.737_368_878_078_319_7, 0.675_490_294_261_523_8];

/// Directions that are spread evenly, and buffers that are used again for each face.
pub(crate) struct Thinning {
    /// Samples that all faces together keep where few faces are left.
    few_faces_samples: usize,
    directions: Vec<DVec3>,
    /// The samples of the face.
    all: Vec<u32>,
    /// Indices in `all` of samples that are farthest from the face.
    farthest: Vec<usize>,
    /// And of samples that are outermost.
    outermost: Vec<usize>,
    /// The samples that the face keeps.
    kept: Vec<u32>,
    /// The squared distance of each sample to the nearest one kept, and its index in `kept`; -1
    /// for one that is kept.
    nearest_kept: Vec<(f64, u32)>,
}

impl Thinning {
    /// `few_faces_samples`: samples that all faces together keep where few faces are left.
    pub(crate) fn new(few_faces_samples: usize) -> Self {
        // Points on a spiral from pole to pole (as Swinbank and Purser 2006 place them).
        let mut turn = [1.0, 0.0];
        let point = |i: usize| {
            let ([x, y], [c, s]) = (turn, GOLDEN_ANGLE);
            turn = [x * c - y * s, x * s + y * c];
            let z = (2 * i + 1) as f64 / DIRECTIONS as f64 - 1.0;
            let radius = (1.0 - z * z).sqrt();
            DVec3::new(radius * x, radius * y, z)
        };
        Self {
            few_faces_samples,
            directions: (0..DIRECTIONS).map(point).collect(),
            all: vec![],
            farthest: vec![],
            outermost: vec![],
            kept: vec![],
            nearest_kept: vec![],
        }
    }

    /// Leaves a face that has many samples the farthest, others far from each other, and the
    /// outermost ones where it may decide the largest squared distance so far, `max_squared`. The
    /// samples kept take over the area of those dropped.
    pub(crate) fn thin(
        &mut self,
        samples: &mut Samples,
        faces: &mut [Face],
        face: u32,
        live_faces: u32,
        max_squared: f64,
    ) {
        let keep = (self.few_faces_samples / live_faces.max(1) as usize).clamp(MIN_KEPT, MAX_KEPT);
        let count = faces[face as usize].sample_count as usize;
        if count <= keep + keep / 2 {
            return;
        }
        let keep_outermost = keep < MIN_KEPT + DIRECTIONS
            && may_decide(samples, &faces[face as usize], live_faces, max_squared);
        if keep_outermost && count <= (keep + DIRECTIONS) * 3 / 2 {
            return;
        }
        self.all.clear();
        self.all.extend(samples.of_face(&faces[face as usize]));
        self.choose(&samples.all, keep, keep_outermost);
        for (&sample, &(apart, nearest)) in self.all.iter().zip(&self.nearest_kept) {
            let is_dropped = apart >= 0.0;
            if is_dropped {
                samples.drop(sample, self.kept[nearest as usize]);
            }
        }
        faces[face as usize].first_sample = NONE;
        faces[face as usize].sample_count = 0;
        for &sample in &self.kept {
            samples.link(faces, face, sample);
        }
    }

    /// Fills `kept` with `keep` of the samples in `all`: the farthest from the face, then each as
    /// far as possible from all before it; besides those the outermost ones, if asked for. Fills
    /// `nearest_kept`, too.
    fn choose(&mut self, samples: &[Sample], keep: usize, keep_outermost: bool) {
        let Self { all, kept, nearest_kept, .. } = self;
        let by_distance = |&a: &usize, &b: &usize| {
            let squared = |i: usize| samples[all[i] as usize].squared_distance;
            squared(a).total_cmp(&squared(b)).then(all[b].cmp(&all[a]))
        };
        // The farthest ones, the very farthest last.
        let farthest = &mut self.farthest;
        farthest.clear();
        farthest.extend(0..all.len());
        let few = (keep / FARTHEST_DIVISOR).max(1);
        let (from, ..) = farthest.select_nth_unstable_by(all.len() - few, by_distance);
        let from = from.len();
        farthest.drain(..from);
        farthest.sort_unstable_by(by_distance);
        let mut choice = farthest.pop().expect("there are many");
        kept.clear();
        nearest_kept.clear();
        nearest_kept.resize(all.len(), (f64::INFINITY, 0));
        self.outermost.clear();
        if keep_outermost {
            self.find_outermost(samples);
            self.outermost.retain(|i| *i != choice && !self.farthest.contains(i));
        }
        let Self { all, kept, nearest_kept, outermost, farthest, .. } = self;
        let keep = keep + outermost.len();
        while kept.len() < keep {
            let kept_index = kept.len() as u32;
            kept.push(all[choice]);
            let position = samples[all[choice] as usize].position();
            nearest_kept[choice].0 = -1.0;
            // The squared distance and index of the sample farthest from all kept.
            let mut most_apart = (-1.0, choice);
            for (i, nearest) in nearest_kept.iter_mut().enumerate() {
                let apart = (samples[all[i] as usize].position() - position).length_squared();
                if apart < nearest.0 {
                    *nearest = (apart, kept_index);
                }
                if nearest.0 > most_apart.0 {
                    most_apart = (nearest.0, i);
                }
            }
            choice = farthest.pop().or_else(|| outermost.pop()).unwrap_or(most_apart.1);
        }
    }

    /// Fills `outermost` with the samples that are outermost in one of the directions, each once.
    fn find_outermost(&mut self, samples: &[Sample]) {
        let Self { directions, all, outermost, .. } = self;
        for &direction in &*directions {
            let mut highest = (f64::NEG_INFINITY, 0);
            for (i, &sample) in all.iter().enumerate() {
                let height = samples[sample as usize].position().dot(direction);
                if height > highest.0 {
                    highest = (height, i);
                }
            }
            outermost.push(highest.1);
        }
        outermost.sort_unstable();
        outermost.dedup();
    }
}

/// Returns whether a face may decide the largest squared distance so far, `max_squared`, and has
/// come from so large an area that a few samples do not represent its shape.
fn may_decide(samples: &Samples, face: &Face, live_faces: u32, max_squared: f64) -> bool {
    let (mut farthest_squared, mut area) = (0.0f32, 0.0);
    for sample in samples.of_face(face).map(|s| &samples.all[s as usize]) {
        farthest_squared = farthest_squared.max(sample.squared_distance);
        area += f64::from(sample.area);
    }
    f64::from(farthest_squared) > OUTERMOST_BEYOND * max_squared
        && area * f64::from(live_faces) > OUTERMOST_AREA_RATIO * samples.area
}
