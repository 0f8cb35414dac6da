//! The error of a patch's samples before and after a move.

use super::appearance::Appearance;
use super::lanes::{self, Four, Shaded4};
use super::patch::{MAX_STAR, Patch};
use super::pixel::{MAX_GEOMETRY, Shading, UNCOVERED};
use super::samples::{Sample, Samples, mix, mix_coordinates};
use super::vectors::{Places, Vec3x4, cosines};
use super::{DISTANCE, PIXELS};
use glam::{Vec3, Vec4};
use lodc_mesh::NONE;

/// Energy of a place of a face where the input has nothing: what was background shows a surface,
/// which is less than a white place that shows the background ([`pixel`](super::pixel)). Chosen by
/// pictures of wire frames; not tuned since.
const SPURIOUS: f32 = 2.0;
/// Energy per curvature and distance: a silhouette that is off by d uncovers a strip of width d,
/// and a surface of mean convex curvature H and area A shows 2 H A d of it, in the unit of its own
/// projected area. By that the factor would be 2; with 6 image errors of eight textured models are
/// lower by 0.02 at 10 % and 0.04 at 5 %; presumably since the background differs from a surface by
/// more than two shades of it do.
const SILHOUETTE: f32 = 6.0;
/// Energy of texture coordinates that are off by a pixel, squared: 0.03 of what the same distance
/// in space has. Measured: 0.1 stretches no less, and has 1 % more image error over eight models.
const SLIDE: f32 = 0.03 / (DISTANCE * PIXELS * DISTANCE * PIXELS) as f32;
/// Places of moved faces that are tested for input nearby, as shares of the second and third
/// corner: the centroid and the centroids of three corner parts. A hole smaller than those is
/// missed.
const PLACES: [[f32; 2]; 4] = [
    [1.0 / 3.0, 1.0 / 3.0],
    [2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0],
    [1.0 / 6.0, 1.0 / 6.0],
];

/// Four samples of the star and what the moved faces show in their place.
struct Fit {
    places: Places,
    /// Errors by shading and by distance, times the weights.
    shading: Vec4,
    geometric: Vec4,
    /// Errors of shading by what is shown there, if there are textures.
    shown: Option<[Shading; 4]>,
}

impl Patch {
    /// The energy of the patch with the star moved, or a part of it that is more than `most`.
    /// `distance_weight` is the energy of a squared distance of one.
    pub(super) fn energy(
        &self,
        samples: &Samples,
        appearance: &Appearance<'_>,
        distance_weight: f32,
        most: f64,
    ) -> f64 {
        let mut sum = 0.0;
        for four in &self.samples {
            let error = if self.moved.is_empty() {
                // No face is left: nothing covers them.
                four.weight * UNCOVERED
            } else {
                let fit = self.fit(four, samples, appearance, distance_weight);
                fit.shading + fit.geometric
            };
            // No part is negative.
            sum += lanes::sum(error);
            if sum > most {
                return sum;
            }
        }
        for i in 0..self.surrounding.len() {
            sum += self.surrounding_energy(i, samples);
            if sum > most {
                return sum;
            }
        }
        for i in 0..self.moved.len() {
            sum += f64::from(self.spurious(i));
        }
        sum
    }

    /// Gives each of the star's samples to the moved face nearest to it, and stores the energy of
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
        for four in self.samples.iter().filter(|_| !self.moved.is_empty()) {
            let Fit { places, geometric, shown, .. } =
                self.fit(four, samples, appearance, distance_weight);
            for (i, &s) in four.ids.iter().enumerate().filter(|(_, s)| **s != NONE) {
                sum += f64::from(four.weight[i]) * f64::from(places.squared[i]);
                visible += f64::from(four.weight[i]);
                let face = self.moved[places.face[i] as usize].face;
                let at = places.at.map(|lane| lane[i]);
                let shading = shown.map_or(samples.get(s).shading, |four| four[i]);
                samples.put(s, face, at, geometric[i], shading);
            }
        }
        let mut lanes = Vec::new();
        for (i, f) in self.moved.iter().enumerate() {
            samples.thin(f.face);
            lanes.clear();
            Shaded4::gather(f.face, samples, &mut lanes);
            let seen: f64 = lanes.iter().map(|four| four.energy(&f.shading)).sum();
            let spurious = self.spurious(i);
            energy[f.face as usize] = seen + f64::from(spurious);
            samples.set_spurious(f.face, spurious);
        }
        for (i, f) in self.surrounding.iter().enumerate() {
            energy[f.face as usize] = self.surrounding_energy(i, samples);
        }
        if visible > 0.0 { (sum / visible).sqrt() } else { 0.0 }
    }

    /// The energy of a face around the star, shaded with the moved faces.
    fn surrounding_energy(&self, i: usize, samples: &Samples) -> f64 {
        let f = &self.surrounding[i];
        let end = self.surrounding.get(i + 1).map_or(self.shaded.len(), |next| next.first as usize);
        let shading = self.surrounding_shading(f);
        let fours = &self.shaded[f.first as usize..end];
        let seen: f64 = fours.iter().map(|four| four.energy(&shading)).sum();
        seen + f64::from(samples.spurious(f.face))
    }

    /// Finds what the moved faces, of which there is one at least, show in the place of four
    /// samples.
    fn fit(
        &self,
        four: &Four,
        samples: &Samples,
        appearance: &Appearance<'_>,
        distance_weight: f32,
    ) -> Fit {
        let planes = self.placed.iter().zip(&self.moved).map(|(p, f)| (*p, f.normal));
        let places = four.nearest(planes);
        let (faces, [u, v]) = (places.face.to_array(), places.at.map(|lane| lane.to_array()));
        let mut normals = [Vec3::ZERO; 4];
        for i in 0..4 {
            normals[i] = mix(&self.moved[faces[i] as usize].shading, [u[i], v[i]]);
        }
        let mut shading = four.shading;
        let mut shown = None;
        if appearance.is_textured() {
            let (mut all, mut lanes) = ([Shading::default(); 4], Shading::default());
            for (i, &s) in four.ids.iter().enumerate().filter(|(_, s)| **s != NONE) {
                let (s, f) = (samples.get(s), &self.moved[faces[i] as usize]);
                let at = mix_coordinates(&f.texture, [u[i], v[i]]);
                let now = appearance.colour(f.submesh, at, s.footprint);
                all[i] = Shading::new(s.colour, now).plus(slid(s, at));
                lanes.set(i, &all[i]);
            }
            (shading, shown) = (lanes.lanes(), Some(all));
        }
        Fit {
            places,
            shading: four.weight * shading.error(cosines(Vec3x4::new(&normals), four.normal)),
            geometric: four.weight * geometric_error(four, &places, distance_weight),
            shown,
        }
    }

    /// The energy of the part of a moved face that lies where the input has nothing: beyond the
    /// extent of every sample. Not evaluated in wide stars, which only inputs have.
    fn spurious(&self, i: usize) -> f32 {
        if self.moved.len() > MAX_STAR {
            return 0.0;
        }
        let placed = &self.placed[i];
        // Its own samples are likely to be nearest.
        let (others, own) = self.samples.split_at(self.moved[i].first as usize);
        let share = |at: [f32; 2]| {
            let place = placed.at(at);
            let around = own.iter().chain(others);
            if around.clone().any(|four| four.reaches(place)) {
                return 0.0;
            }
            let least = around.fold(Vec4::splat(2.0), |least, four| four.shares(place).min(least));
            (least.min_element() - 1.0).max(0.0) / PLACES.len() as f32
        };
        SPURIOUS * self.visible as f32 * placed.area() * PLACES.map(share).iter().sum::<f32>()
    }
}

/// The energy of texture coordinates that slid over the surface, which colours do not tell where a
/// texture repeats within a pixel, or is plain under a normal map.
fn slid(sample: &Sample, at: [f32; 2]) -> f32 {
    if sample.footprint <= 0.0 {
        return 0.0;
    }
    let [u, v] = [0, 1].map(|k| at[k] - sample.texture[k]);
    let squared_pixels = (u * u + v * v) / sample.footprint;
    (SLIDE * squared_pixels).min(1.0) * sample.power
}

/// The errors of four samples by their distances from their places. Beside its own plane nothing
/// covers a sample.
fn geometric_error(four: &Four, places: &Places, distance_weight: f32) -> Vec4 {
    let Places { away, squared, .. } = *places;
    let along = away.dot(four.normal);
    let beside = (squared - along * along).max(Vec4::ZERO).sqrt();
    let is_near = beside.cmplt(four.extent);
    let extent = Vec4::select(is_near, four.extent, Vec4::ONE);
    let uncovered = Vec4::select(is_near, beside / extent, Vec4::ONE);
    let silhouette = SILHOUETTE * four.curvature * squared.sqrt();
    let error = distance_weight * squared + silhouette + UNCOVERED * uncovered;
    error.min(Vec4::splat(MAX_GEOMETRY)) * four.power
}
