//! Samples of the input's surface, which the forward pass (from the input to the level) follows:
//! each belongs to a face of the current level, the nearest as far as it matters.

use crate::block::TouchedFace;
use crate::faces::Face;
use crate::input::{Input, to_dvec3};
use crate::origin::Origin;
use glam::DVec3;
use lodc_mesh::{NONE, SplitMix64};
use lodc_nearest::{Triangles, area, centroid, longest_edge_squared};

/// Most samples put inside a large or long triangle. Where they do not suffice, the triangle is
/// searched as a whole. Chosen by hand: more take time in every step.
const MAX_EXTRA_SAMPLES: f64 = 24.0;

/// And on average over all triangles: where most of them are long, each lies beside others. Chosen
/// by hand.
const MAX_MEAN_EXTRA_SAMPLES: f64 = 4.0;

/// Triangles above this many times the mean area have samples inside, one for each
/// [`AREA_PER_SAMPLE`] mean areas. Chosen by hand.
const LARGE_AREA_RATIO: f64 = 3.0;
const AREA_PER_SAMPLE: f64 = 2.0;

/// So have triangles with an edge this many times as long as the side of a square of the mean area,
/// one for each half of that length. Chosen by hand.
const LONG_EDGE_RATIO: f64 = 6.0;

/// Most samples that one triangle of a mesh of few gets, as a share of the mesh's: 106 of 20,000.
/// Chosen by hand; a `u8` holds the number.
const MAX_SHARE_OF_SAMPLES: f64 = 1.0 / 187.5;

/// The `next` of a sample in the list of no face: thinned out, or at a point of no triangle.
const DROPPED: u32 = NONE - 1;

/// A position on the surface of the input, in units of [`Input::coordinates`]; half a cache line.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(crate) struct Sample {
    position: [f32; 3],
    /// The next sample of the same face; [`NONE`] at the end, [`DROPPED`] in the list of none.
    next: u32,
    pub(crate) origin: Origin,
    /// Squared distance to its face.
    pub(crate) squared_distance: f32,
    /// Its squared distance when the triangles of its origin were last searched for a farther
    /// point; 0 if they were not.
    pub(crate) searched_at_squared: f32,
    /// The area of the input that belongs to it.
    pub(crate) area: f32,
}

impl Sample {
    /// A sample of no area inside a triangle of the input.
    pub(crate) fn without_area(position: [f32; 3], triangle: u32) -> Self {
        Self::new(position, Origin::triangle(triangle), 0.0)
    }

    fn new(position: [f32; 3], origin: Origin, area: f32) -> Self {
        let (squared_distance, searched_at_squared) = (0.0, 0.0);
        Self { position, next: NONE, origin, squared_distance, searched_at_squared, area }
    }

    #[inline]
    pub(crate) fn position(&self) -> DVec3 {
        to_dvec3(self.position)
    }
}

/// All samples, in a linked list for each face: first one for every point of the input, in order.
pub(crate) struct Samples {
    pub(crate) all: Vec<Sample>,
    /// The sum of area times squared distance.
    pub(crate) area_times_squared: f64,
    /// The sum of areas: that of the input.
    pub(crate) area: f64,
}

impl Samples {
    /// Puts a sample at every point of the input, and more inside of large and long triangles; some
    /// `few_triangles_samples` in all on a mesh of fewer triangles than that.
    pub(crate) fn new(input: &Input, faces: &mut [Face], few_triangles_samples: f64) -> Self {
        let areas: Vec<f32> =
            faces.iter().map(|f| area(input.corners_of(f.points)) as f32).collect();
        let extra_counts = extra_counts(input, faces, &areas, few_triangles_samples);
        let extra: u64 = extra_counts.iter().map(|&n| u64::from(n)).sum();
        let mut samples = Self {
            all: Vec::with_capacity(input.coordinates.len() + extra as usize),
            area_times_squared: 0.0,
            area: areas.iter().copied().map(f64::from).sum(),
        };
        // A triangle's area is shared equally by its corners and the samples inside of it.
        let share = |(&area, &n): (&f32, &u8)| (f64::from(area) / (3.0 + f64::from(n))) as f32;
        let shares: Vec<f32> = areas.iter().zip(&extra_counts).map(share).collect();
        for (point, &position) in (0..).zip(&input.coordinates) {
            let around = input.triangles_around.row(point);
            let area = around.iter().map(|&t| shares[t as usize]).sum();
            samples.all.push(Sample::new(position, Origin::point(point), area));
            match around.first() {
                Some(&t) => samples.link(faces, t, point),
                None => samples.all[point as usize].next = DROPPED,
            }
        }
        let mut random = SplitMix64::new(7);
        for (t, &n) in (0..).zip(&extra_counts) {
            let [a, b, c] = if n > 0 { input.corners(t) } else { continue };
            for _ in 0..n {
                let (mut u, mut v) = (f64::from(random.unit()), f64::from(random.unit()));
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                let p = a + (b - a) * u + (c - a) * v;
                let position = p.to_array().map(|x| x as f32);
                let sample = Sample::new(position, Origin::triangle(t), shares[t as usize]);
                samples.add(faces, t, sample);
            }
        }
        samples
    }

    /// Adds a sample to the list of a face. Returns its index in `all`.
    pub(crate) fn add(&mut self, faces: &mut [Face], face: u32, sample: Sample) -> u32 {
        let index = self.all.len() as u32;
        self.all.push(sample);
        self.link(faces, face, index);
        index
    }

    /// Puts a sample that is in no list into that of a face.
    pub(crate) fn link(&mut self, faces: &mut [Face], face: u32, sample: u32) {
        let face = &mut faces[face as usize];
        self.all[sample as usize].next = face.first_sample;
        face.first_sample = sample;
        face.sample_count = face.sample_count.saturating_add(1);
    }

    /// Marks a sample that was taken out of the list of its face; `kept`, which is in it, takes
    /// over its area.
    pub(crate) fn drop(&mut self, sample: u32, kept: u32) {
        let dropped = &mut self.all[sample as usize];
        let (area, squared) = (std::mem::take(&mut dropped.area), dropped.squared_distance);
        dropped.next = DROPPED;
        let kept = &mut self.all[kept as usize];
        kept.area += area;
        let change = f64::from(kept.squared_distance) - f64::from(squared);
        self.area_times_squared += f64::from(area) * change;
    }

    /// Whether the sample at a point of the input was dropped.
    pub(crate) fn is_dropped(&self, point: u32) -> bool {
        self.all[point as usize].next == DROPPED
    }

    /// Empties the list of a face: appends its samples to `unlinked`, each with the face.
    pub(crate) fn unlink_all(
        &self,
        faces: &mut [Face],
        face: u32,
        unlinked: &mut Vec<SampleOnFace>,
    ) {
        let on_face = |sample| SampleOnFace { sample, face };
        unlinked.extend(self.of_face(&faces[face as usize]).map(on_face));
        faces[face as usize].first_sample = NONE;
        faces[face as usize].sample_count = 0;
    }

    /// Sets a sample's squared distance to its face.
    pub(crate) fn set_squared_distance(&mut self, sample: u32, squared: f64) {
        let s = &mut self.all[sample as usize];
        let squared = squared as f32;
        let change = f64::from(squared) - f64::from(s.squared_distance);
        self.area_times_squared += f64::from(s.area) * change;
        s.squared_distance = squared;
    }

    /// Returns a word of a sample, to load its cache line early.
    #[inline]
    pub(crate) fn touch(&self, sample: u32) -> u32 {
        self.all.get(sample as usize).map_or(0, |s| s.next)
    }

    /// The samples of a face, as indices in `all`.
    pub(crate) fn of_face(&self, face: &Face) -> impl Iterator<Item = u32> {
        let some = |sample: u32| (sample != NONE).then_some(sample);
        std::iter::successors(some(face.first_sample), move |&s| some(self.all[s as usize].next))
    }

    /// Returns the mean squared distance of all samples.
    pub(crate) fn mean_square(&self) -> f64 {
        if self.area > 0.0 { (self.area_times_squared / self.area).max(0.0) } else { 0.0 }
    }

    /// Returns what the backward pass has to know of a live face, `index`, at its corners.
    pub(crate) fn touched_face(&self, corners: [DVec3; 3], index: u32, face: &Face) -> TouchedFace {
        let centroid = centroid(corners);
        let (mut least, mut origin) = (f64::INFINITY, Origin::NONE);
        for sample in self.of_face(face).map(|s| &self.all[s as usize]) {
            let to_centroid = (sample.position() - centroid).length_squared();
            if to_centroid < least {
                (least, origin) = (to_centroid, sample.origin);
            }
        }
        TouchedFace { face: index, is_live: true, points: face.points, origin }
    }
}

/// A sample and the face that it belongs to, or belonged to before the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleOnFace {
    pub(crate) sample: u32,
    pub(crate) face: u32,
}

/// Returns for each face how many samples go inside it; see [`Samples::new`].
fn extra_counts(
    input: &Input,
    faces: &[Face],
    areas: &[f32],
    few_triangles_samples: f64,
) -> Vec<u8> {
    let longest_edge = |f: &Face| longest_edge_squared(input.corners_of(f.points)).sqrt();
    let has_few_triangles = (faces.len() as f64) < few_triangles_samples;
    let total_area: f64 = areas.iter().copied().map(f64::from).sum();
    let total_length: f64 =
        if has_few_triangles { faces.iter().map(longest_edge).sum() } else { 0.0 };
    let mean_area = total_area / faces.len().max(1) as f64;
    // Samples for a triangle that is large or long, and for one of a mesh of few.
    let counts = |(f, &area): (&Face, &f32)| {
        let (area, length) = (f64::from(area), longest_edge(f));
        let for_area = if area > LARGE_AREA_RATIO * mean_area {
            area / (AREA_PER_SAMPLE * mean_area)
        } else {
            0.0
        };
        let for_length = if length > LONG_EDGE_RATIO * mean_area.sqrt() {
            length / (LONG_EDGE_RATIO / 2.0 * mean_area.sqrt())
        } else {
            0.0
        };
        // Half of them by area, half by length.
        let for_few = if has_few_triangles && total_length > 0.0 && total_area > 0.0 {
            (0.5 * few_triangles_samples * (area / total_area + length / total_length))
                .min(few_triangles_samples * MAX_SHARE_OF_SAMPLES)
        } else {
            0.0
        };
        [for_area.max(for_length).min(MAX_EXTRA_SAMPLES), for_few]
    };
    let all = || faces.iter().zip(areas).map(counts);
    let extra: f64 = all().map(|[extra, _]| extra).sum();
    let share = (MAX_MEAN_EXTRA_SAMPLES * faces.len() as f64 / extra.max(1.0)).min(1.0);
    all().map(|[extra, for_few]| (extra * share).max(for_few) as u8).collect()
}
