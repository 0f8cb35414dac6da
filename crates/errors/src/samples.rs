//! Samples of the input's surface: each belongs to its nearest face of the level at hand.

use crate::block::Entry;
use crate::faces::Face;
use crate::input::{Input, wide};
use glam::DVec3;
use lodc_mesh::{NONE, SplitMix64};
use lodc_nearest::centroid;
use std::ops::RangeInclusive;

/// Most samples put on a large or long triangle besides its corners. Where they do not suffice, the
/// triangle is searched as a whole.
const MOST_INSIDE: f64 = 24.0;

/// Triangles with an edge this many times as long as the side of a square of the mean area have
/// samples along it.
const LONG: f64 = 6.0;

/// Most of the samples of a mesh of few triangles that one of them gets, as a share: 160 of 30,000.
const MOST_OF_FEW: f64 = 1.0 / 187.5;

/// Samples tell a face's mean distance if the areas that belong to them are this many times its
/// own. Where they are more, some come from parts that are gone: these are far from the face, not
/// it from the input (folds of noise that became flat are no more than about three times as large).
/// Where they are fewer, the face is larger than what it came from: it is a web or a needle.
const TELLING: RangeInclusive<f64> = 0.25..=4.0;

/// A point of the input, half a cache line.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(crate) struct Sample {
    place: [f32; 3],
    /// The next sample of the same face.
    next: u32,
    /// Its origin: twice the point that it is, or twice the triangle that it lies in, plus
    /// 1.
    origin: u32,
    /// Squared distance to its face.
    pub(crate) squared: f32,
    /// The squared distance at which the input around it was searched last.
    pub(crate) refined: f32,
    /// The area of the input that belongs to it.
    pub(crate) weight: f32,
}

impl Sample {
    #[inline]
    pub(crate) fn place(&self) -> DVec3 {
        wide(self.place)
    }

    /// Returns the triangles of the input that it lies on.
    pub(crate) fn sources<'a>(&self, input: &'a Input) -> Sources<'a> {
        sources(input, self.origin)
    }
}

/// Returns the triangles of the input that a sample with some origin lies on.
pub(crate) fn sources(input: &Input, origin: u32) -> Sources<'_> {
    let which = origin / 2;
    if origin.is_multiple_of(2) {
        Sources::Around(input.around.row(which))
    } else {
        Sources::Inside(which)
    }
}

/// Triangles that a sample lies on.
pub(crate) enum Sources<'a> {
    /// Those around a point.
    Around(&'a [u32]),
    /// One that it lies inside of.
    Inside(u32),
}

impl Sources<'_> {
    /// Returns the triangles.
    pub(crate) fn as_slice(&self) -> &[u32] {
        match self {
            Self::Around(row) => row,
            Self::Inside(triangle) => std::slice::from_ref(triangle),
        }
    }
}

/// All samples, in a list for each face.
pub(crate) struct Samples {
    pub(crate) all: Vec<Sample>,
    /// The sum of weight times squared distance.
    pub(crate) sum: f64,
    /// The sum of weights, and the share of it that points have.
    pub(crate) weight: f64,
    pub(crate) at_points: f64,
}

impl Samples {
    /// Puts a sample at every point of the input, and more on triangles above three times the mean
    /// area; on all triangles of a mesh that has not `fewest` of them.
    pub(crate) fn new(input: &Input, faces: &mut [Face], fewest: f64) -> Self {
        let areas: Vec<f32> = faces.iter().map(|f| area(input.at(f.points))).collect();
        let inside = inside(input, faces, &areas, fewest);
        let extra: u64 = inside.iter().map(|&n| u64::from(n)).sum();
        let mut samples = Self {
            all: Vec::with_capacity(input.places.len() + extra as usize),
            sum: 0.0,
            weight: areas.iter().copied().map(f64::from).sum(),
            at_points: 0.0,
        };
        // A triangle's area is shared equally by its corners and the samples inside of it.
        let share = |(&area, &n): (&f32, &u8)| (f64::from(area) / (3.0 + f64::from(n))) as f32;
        let shares: Vec<f32> = areas.iter().zip(&inside).map(share).collect();
        for (point, &place) in (0..).zip(&input.places) {
            let around = input.around.row(point);
            if let Some(&t) = around.first() {
                let weight = around.iter().map(|&t| shares[t as usize]).sum();
                samples.at_points += f64::from(weight) / samples.weight.max(f64::MIN_POSITIVE);
                samples.add(faces, t, Sample::at_point(place, point, weight));
            }
        }
        let mut random = SplitMix64::new(7);
        for (t, &n) in (0..).zip(&inside) {
            let [a, b, c] = if n > 0 { input.at(input.triangles[t as usize]) } else { continue };
            for _ in 0..n {
                let (mut u, mut v) = (f64::from(random.unit()), f64::from(random.unit()));
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                let p = a + (b - a) * u + (c - a) * v;
                let place = p.to_array().map(|x| x as f32);
                samples.add(faces, t, Sample::inside(place, t, shares[t as usize]));
            }
        }
        samples
    }

    /// Adds a sample to the list of a face. Returns its number.
    pub(crate) fn add(&mut self, faces: &mut [Face], face: u32, sample: Sample) -> u32 {
        let number = self.all.len() as u32;
        self.all.push(sample);
        self.link(faces, face, number);
        number
    }

    /// Puts a sample that is in no list into that of a face.
    pub(crate) fn link(&mut self, faces: &mut [Face], face: u32, sample: u32) {
        let face = &mut faces[face as usize];
        self.all[sample as usize].next = face.first_sample;
        face.first_sample = sample;
        face.samples = face.samples.saturating_add(1);
    }

    /// Appends the samples of a face to `taken`, with the face, and leaves the face without.
    pub(crate) fn take(&self, faces: &mut [Face], face: u32, taken: &mut Vec<(u32, u32)>) {
        taken.extend(self.of(&faces[face as usize]).map(|sample| (sample, face)));
        faces[face as usize].first_sample = NONE;
        faces[face as usize].samples = 0;
    }

    /// Notes a sample's new distance.
    pub(crate) fn set(&mut self, sample: u32, squared: f64) {
        let s = &mut self.all[sample as usize];
        let squared = squared as f32;
        self.sum += f64::from(s.weight) * (f64::from(squared) - f64::from(s.squared));
        s.squared = squared;
    }

    /// Returns a word of a sample, which fetches it into the cache.
    #[inline]
    pub(crate) fn touch(&self, sample: u32) -> u32 {
        self.all.get(sample as usize).map_or(0, |s| s.next)
    }

    /// The samples of a face.
    pub(crate) fn of(&self, face: &Face) -> impl Iterator<Item = u32> {
        let some = |sample: u32| (sample != NONE).then_some(sample);
        std::iter::successors(some(face.first_sample), move |&s| some(self.all[s as usize].next))
    }

    /// Returns the mean squared distance of all samples.
    pub(crate) fn mean_square(&self) -> f64 {
        if self.weight > 0.0 { (self.sum / self.weight).max(0.0) } else { 0.0 }
    }

    /// Returns what the backward pass, from the level to the input, has to know of a live face.
    pub(crate) fn entry(&self, corners: [DVec3; 3], number: u32, face: &Face) -> Entry {
        let (middle, area) = (centroid(corners), area(corners));
        let (mut sum, mut weight, mut near, mut hint) = (0.0, 0.0, f64::INFINITY, NONE);
        for sample in self.of(face).map(|s| &self.all[s as usize]) {
            sum += f64::from(sample.weight) * f64::from(sample.squared);
            weight += f64::from(sample.weight);
            let apart = (sample.place() - middle).length_squared();
            if apart < near {
                (near, hint) = (apart, sample.origin);
            }
        }
        let is_told = TELLING.contains(&(weight / f64::from(area)));
        let mean_square = if is_told { (sum / weight) as f32 } else { f32::NAN };
        Entry { face: number, is_live: true, points: face.points, mean_square, hint }
    }
}

impl Sample {
    fn new(place: [f32; 3], origin: u32, weight: f32) -> Self {
        Self { place, next: NONE, origin, squared: 0.0, refined: 0.0, weight }
    }

    fn at_point(place: [f32; 3], point: u32, weight: f32) -> Self {
        Self::new(place, 2 * point, weight)
    }

    /// A sample inside a triangle of the input.
    pub(crate) fn inside(place: [f32; 3], triangle: u32, weight: f32) -> Self {
        Self::new(place, 2 * triangle + 1, weight)
    }
}

/// Returns for each face how many samples go inside it.
fn inside(input: &Input, faces: &[Face], areas: &[f32], fewest: f64) -> Vec<u8> {
    let longest = |f: &Face| {
        let [a, b, c] = input.at(f.points);
        (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared()).sqrt()
    };
    let is_few = (faces.len() as f64) < fewest;
    let all: f64 = areas.iter().copied().map(f64::from).sum();
    let lengths: f64 = if is_few { faces.iter().map(longest).sum() } else { 0.0 };
    let mean = all / faces.len().max(1) as f64;
    let many = |(f, &area): (&Face, &f32)| {
        let (area, length) = (f64::from(area), longest(f));
        let large = if area > 3.0 * mean { area / (2.0 * mean) } else { 0.0 };
        let long =
            if length > LONG * mean.sqrt() { length / (LONG / 2.0 * mean.sqrt()) } else { 0.0 };
        let few = if is_few && lengths > 0.0 && all > 0.0 {
            (0.5 * fewest * (area / all + length / lengths)).min(fewest * MOST_OF_FEW)
        } else {
            0.0
        };
        large.max(long).min(MOST_INSIDE).max(few) as u8
    };
    faces.iter().zip(areas).map(many).collect()
}

/// Returns the area of a face at some corners.
pub(crate) fn area(corners: [DVec3; 3]) -> f32 {
    lodc_nearest::area(corners) as f32
}
