//! The error of a patch's samples before and after a move.

use super::appearance::{Appearance, Colour};
use super::patch::{Patch, WIDE};
use super::pixel::{MAX_GEOMETRY, UNCOVERED, shading_error};
use super::samples::{Sample, Samples, mix, mix_coordinates};
use glam::{Vec3, Vec4};

/// Energy of a place of a face where the input has nothing.
const SPURIOUS: f32 = 2.0;
/// Energy per curvature and distance: a silhouette that is off by d uncovers a strip of width d,
/// and a surface of mean convex curvature H and area A shows 2 H A d of it, in the unit of its own
/// projected area. The factor is measured.
const SILHOUETTE: f32 = 6.0;
/// Squared distance, in squared extents, by which a face that turns its back comes later.
const TURNED: f32 = 0.25;
/// Places of moved faces that are tested for input nearby: shares of the second and third corner.
const PLACES: [[f32; 2]; 4] = [
    [1.0 / 3.0, 1.0 / 3.0],
    [2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0],
    [1.0 / 6.0, 1.0 / 6.0],
];

/// A place in a moved face.
#[derive(Clone, Copy)]
struct Place {
    /// Index of the moved face.
    face: usize,
    /// Shares of the second and third corner.
    at: [f32; 2],
    /// Squared distance from the sample.
    squared: f32,
}

impl Patch {
    /// The energy of the patch with the star moved. `distance_weight` is the energy of a squared
    /// distance of one.
    pub(super) fn energy(
        &self,
        samples: &Samples,
        appearance: &Appearance<'_>,
        distance_weight: f32,
    ) -> f64 {
        let mut sum = 0.0;
        for &s in &self.samples {
            let s = samples.get(s);
            let Some(place) = self.nearest(s) else {
                // Nothing is left that could stand for it.
                sum += f64::from(s.weight * UNCOVERED);
                continue;
            };
            let shown = self.colour(place, s, appearance);
            let cosine = cosine(&self.moved[place.face].shading, place.at, s.normal);
            let error = shading_error(cosine, s.colour, shown)
                + self.geometric_error(place, s, distance_weight);
            sum += f64::from(s.weight * error);
        }
        for f in &self.surrounding {
            sum += face_energy(f.face, &self.surrounding_shading(f), samples)
                + f64::from(samples.spurious(f.face));
        }
        for i in 0..self.moved.len() {
            sum += f64::from(self.spurious(i));
        }
        sum
    }

    /// Gives the star's samples to the faces that now stand for them, and stores the energy of
    /// every face of the patch. Returns the root mean square distance of visible samples from their
    /// faces, in working units; 0 if none is visible.
    pub(super) fn settle(
        &self,
        samples: &mut Samples,
        appearance: &Appearance<'_>,
        distance_weight: f32,
        energy: &mut [f64],
    ) -> f64 {
        let (mut sum, mut visible) = (0.0, 0.0);
        for &s in &self.samples {
            let sample = *samples.get(s);
            if let Some(place) = self.nearest(&sample) {
                sum += f64::from(sample.weight) * f64::from(place.squared);
                visible += f64::from(sample.weight);
                let geometric = self.geometric_error(place, &sample, distance_weight);
                let shown = self.colour(place, &sample, appearance);
                let face = self.moved[place.face].face;
                samples.put(s, face, place.at, sample.weight * geometric, shown);
            }
        }
        let spurious: Vec<f32> = (0..self.moved.len()).map(|i| self.spurious(i)).collect();
        for (f, spurious) in self.moved.iter().zip(spurious) {
            samples.thin(f.face);
            energy[f.face as usize] =
                face_energy(f.face, &f.shading, samples) + f64::from(spurious);
            samples.set_spurious(f.face, spurious);
        }
        for f in &self.surrounding {
            energy[f.face as usize] = face_energy(f.face, &self.surrounding_shading(f), samples)
                + f64::from(samples.spurious(f.face));
        }
        if visible > 0.0 { (sum / visible).sqrt() } else { 0.0 }
    }

    /// The place of the moved faces that is nearest to a sample. A face that turns its back to it
    /// comes after one nearly as near that does not: where faces coincide, each keeps its samples.
    fn nearest(&self, sample: &Sample) -> Option<Place> {
        let mut best: Option<(Place, f32)> = None;
        let turned = TURNED * sample.extent * sample.extent;
        for (face, placed) in self.placed.iter().enumerate() {
            let (at, squared) = placed.locate(sample.position);
            let is_turned = self.moved[face].normal.dot(sample.normal) < 0.0;
            let key = squared + if is_turned { turned } else { 0.0 };
            if best.is_none_or(|b| key < b.1) {
                best = Some((Place { face, at, squared }, key));
            }
        }
        best.map(|b| b.0)
    }

    /// The error of a sample by its distance from its place. Beside its own plane nothing covers
    /// it.
    fn geometric_error(&self, place: Place, sample: &Sample, distance_weight: f32) -> f32 {
        let away = sample.position - self.placed[place.face].at(place.at);
        let along = away.dot(sample.normal);
        let beside = (place.squared - along * along).max(0.0).sqrt();
        let uncovered = if beside < sample.extent { beside / sample.extent } else { 1.0 };
        let silhouette = SILHOUETTE * sample.curvature * place.squared.sqrt();
        let error = distance_weight * place.squared + silhouette + UNCOVERED * uncovered;
        error.min(MAX_GEOMETRY) * sample.colour.power()
    }

    /// The colour of a moved face at the place of a sample.
    #[inline]
    fn colour(&self, place: Place, sample: &Sample, appearance: &Appearance<'_>) -> Colour {
        if !appearance.is_textured() {
            return sample.colour;
        }
        let f = &self.moved[place.face];
        appearance.colour(f.submesh, mix_coordinates(&f.texture, place.at), sample.footprint)
    }

    /// The energy of the part of a moved face that lies where the input has nothing: beyond the
    /// extent of every sample. Not evaluated in wide stars, which only inputs have.
    fn spurious(&self, i: usize) -> f32 {
        if self.moved.len() > WIDE {
            return 0.0;
        }
        let placed = &self.placed[i];
        let share = |at: [f32; 2]| {
            let place = placed.at(at);
            let shares = self.reaches.iter().map(|four| four.shares(place));
            let least = shares.fold(Vec4::splat(2.0), Vec4::min);
            (least.min_element() - 1.0).max(0.0) / PLACES.len() as f32
        };
        SPURIOUS * self.visible as f32 * placed.area() * PLACES.map(share).iter().sum::<f32>()
    }
}

/// The energy of a face whose samples know their places in it.
fn face_energy(face: u32, shading: &[Vec3; 3], samples: &Samples) -> f64 {
    let error = |s| {
        let s = samples.get(s);
        let shading = shading_error(cosine(shading, s.at, s.normal), s.colour, s.shown);
        f64::from(s.weight * shading + s.geometric)
    };
    samples.of(face).map(error).sum()
}

/// The cosine between a sample's normal and the one that a face is shaded with at a place.
#[inline]
fn cosine(shading: &[Vec3; 3], at: [f32; 2], normal: Vec3) -> f32 {
    let n = mix(shading, at);
    let length = n.length();
    if length > 0.0 { n.dot(normal) / length } else { 0.5 }
}
