//! The energy of a patch before and after a move. A patch is the faces around a group that moves,
//! and those around them that are shaded anew ([`Patch`]); its energy is the sum of the errors of
//! its samples, each times the area of its sample. Samples are read four at a time, as *quads*,
//! with one sample in each SIMD lane.

use super::appearance::Appearance;
use super::lanes::{self, SampleQuad, ShadedQuad};
use super::patch::{MAX_STAR, Patch};
use super::pixel::{MAX_GEOMETRY, ShadingError, UNCOVERED};
use super::samples::{Sample, Samples};
use super::vectors::{NearestPoints, Vec3x4, cosines, mix, mix_coordinates};
use super::{DISTANCE_SHARE, PICTURE_PIXELS};
use glam::{Vec3, Vec4};
use lodc_mesh::NONE;

/// Error of a point of a face where the input has nothing: what was background shows a surface.
/// Less than that of a white surface that shows the background ([`pixel`](super::pixel)). Chosen by
/// pictures of wire frames; not tuned since.
const SPURIOUS: f32 = 2.0;
/// Error of an area that covers a layer that was seen before it.
pub(super) const COVERING: f32 = 2.0;
/// Error per curvature and distance: a silhouette that is off by d uncovers a strip of width d,
/// and a surface of mean convex curvature H and area A shows 2 H A d of it, in the unit of its own
/// projected area. That would make the factor 2. With 6 the image errors of eight textured models,
/// as multiples of those of the quadric, are lower by 0.02 at 10 % of the triangles and by 0.04 at
/// 5 %, presumably because the background differs more from a surface than two of its shades do.
const SILHOUETTE: f32 = 6.0;
/// Error of texture coordinates that are off by a pixel: 0.03 of the error of the same distance in
/// space. With 0.1 textures slide as much, and the image errors of eight models are 1 % higher.
const SLIDE: f32 =
    0.03 / (DISTANCE_SHARE * PICTURE_PIXELS * DISTANCE_SHARE * PICTURE_PIXELS) as f32;
/// Points of moved faces that are tested for input nearby, as shares of the second and third
/// corner: the centroid, and the centroids of the three parts at the corners. Smaller holes are
/// missed.
const TESTED_POINTS: [[f32; 2]; 4] = [
    [1.0 / 3.0, 1.0 / 3.0],
    [2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0],
    [1.0 / 6.0, 1.0 / 6.0],
];

/// The shading of four samples at their nearest points.
struct QuadShading {
    /// The errors, each times the weight of its sample.
    error: Vec4,
    /// The error as a function of the normals, for the colours at the nearest points; none where
    /// colours do not vary.
    by_normals: Option<ShadingError<Vec4>>,
}

impl Patch {
    /// The energy of the patch with the star moved, or a part of it that is more than `limit`.
    /// `distance_weight` is the energy of a squared distance of one.
    pub(super) fn energy(
        &mut self,
        samples: &Samples,
        appearance: &Appearance<'_>,
        distance_weight: f32,
        limit: f64,
    ) -> f64 {
        let mut sum = 0.0;
        if self.moved.is_empty() {
            // No face is left: nothing covers the samples.
            sum += self.samples.iter().map(|q| lanes::sum(q.weight * UNCOVERED)).sum::<f64>();
        } else {
            // No part is negative, so the sum may end early. The quickest parts come first.
            self.nearest.clear();
            for (quad, nearest) in lanes::nearest_points(&self.samples, &self.triangles) {
                sum += lanes::sum(geometric_error(quad, &nearest, distance_weight));
                if sum > limit {
                    return sum;
                }
                self.nearest.push(nearest);
            }
            for (quad, nearest) in self.samples.iter().zip(&self.nearest) {
                sum += lanes::sum(self.shading(quad, nearest, samples, appearance).error);
                if sum > limit {
                    return sum;
                }
            }
        }
        for i in 0..self.surrounding.len() {
            sum += self.surrounding_energy(i, samples);
            if sum > limit {
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
        let (mut squared_distances, mut weights) = (0.0, 0.0);
        for (quad, nearest) in lanes::nearest_points(&self.samples, &self.triangles) {
            let geometric = geometric_error(quad, &nearest, distance_weight);
            let by_normals = self.shading(quad, &nearest, samples, appearance).by_normals;
            for (i, &s) in quad.ids.iter().enumerate().filter(|(_, s)| **s != NONE) {
                squared_distances += f64::from(quad.weight[i]) * f64::from(nearest.squared[i]);
                weights += f64::from(quad.weight[i]);
                let face = self.moved[nearest.face[i] as usize].face;
                let at = nearest.at.map(|lane| lane[i]);
                let shading = by_normals.map_or(samples.get(s).shading, |four| four.one(i));
                samples.put(s, face, at, geometric[i], shading);
            }
        }
        let mut quads = Vec::new();
        for (i, f) in self.moved.iter().enumerate() {
            samples.thin(f.face);
            quads.clear();
            ShadedQuad::gather(f.face, samples, &mut quads);
            let seen: f64 = quads.iter().map(|quad| quad.energy(&f.shading)).sum();
            let spurious = self.spurious(i);
            energy[f.face as usize] = seen + f64::from(spurious);
            samples.set_spurious(f.face, spurious);
        }
        for (i, f) in self.surrounding.iter().enumerate() {
            energy[f.face as usize] = self.surrounding_energy(i, samples);
        }
        if weights > 0.0 { (squared_distances / weights).sqrt() } else { 0.0 }
    }

    /// The energy of a face around the star, shaded with the moved faces.
    fn surrounding_energy(&self, i: usize, samples: &Samples) -> f64 {
        let f = &self.surrounding[i];
        let end = self.surrounding.get(i + 1).map_or(self.shaded.len(), |next| next.first as usize);
        let shading = self.surrounding_shading(f);
        let quads = &self.shaded[f.first as usize..end];
        let seen: f64 = quads.iter().map(|quad| quad.energy(&shading)).sum();
        seen + f64::from(samples.spurious(f.face))
    }

    /// The error of the shading that four samples have at their nearest points.
    fn shading(
        &self,
        quad: &SampleQuad,
        nearest: &NearestPoints,
        samples: &Samples,
        appearance: &Appearance<'_>,
    ) -> QuadShading {
        let (faces, [u, v]) = (nearest.face, nearest.at.map(|lane| lane.to_array()));
        let normals = if faces.iter().all(|&f| f == faces[0]) {
            let [second, third] = nearest.at;
            let shares = [Vec4::ONE - second - third, second, third];
            Vec3x4::mix(self.moved[faces[0] as usize].shading, shares)
        } else {
            let mut normals = [Vec3::ZERO; 4];
            for i in 0..4 {
                normals[i] = mix(&self.moved[faces[i] as usize].shading, [u[i], v[i]]);
            }
            Vec3x4::new(&normals)
        };
        let mut shading = quad.shading;
        let mut by_normals = None;
        if appearance.is_coloured() {
            let (mut was, mut now, mut slides) = ([Vec3::ZERO; 4], [Vec3::ZERO; 4], [0.0; 4]);
            for (i, &s) in quad.ids.iter().enumerate().filter(|(_, s)| **s != NONE) {
                let (s, f) = (samples.get(s), &self.moved[faces[i] as usize]);
                let shares = [u[i], v[i]];
                let at = mix_coordinates(&f.texture, shares);
                was[i] = s.colour.channels().into();
                let shown = appearance.colour(f.submesh, f.vertices, shares, at, s.footprint);
                now[i] = shown.channels().into();
                slides[i] = slide_error(s, at);
            }
            let [was, now] = [was, now].map(|colours| Vec3x4::new(&colours));
            shading = ShadingError::of_colours(was, now, slides.into());
            by_normals = Some(shading);
        }
        let error = quad.weight * shading.error(cosines(normals, quad.normal));
        QuadShading { error, by_normals }
    }

    /// The energy of the part of a moved face that lies where the input has nothing: farther from
    /// every sample than the sample covers. 0 in wide stars, which only inputs have.
    fn spurious(&self, i: usize) -> f32 {
        if self.moved.len() > MAX_STAR {
            return 0.0;
        }
        let triangle = &self.triangles[i];
        // Its own samples are likely to be nearest.
        let (other_quads, own_quads) = self.samples.split_at(self.moved[i].first as usize);
        let share = |at: [f32; 2]| {
            let point = triangle.at(at);
            let quads = own_quads.iter().chain(other_quads);
            if quads.clone().any(|quad| quad.covers(point)) {
                return 0.0;
            }
            // From 0 where a sample ends to cover points to 1 at 1.4 times that distance.
            let least = quads
                .fold(Vec4::splat(2.0), |least, quad| quad.relative_distances(point).min(least));
            (least.min_element() - 1.0).max(0.0) / TESTED_POINTS.len() as f32
        };
        SPURIOUS
            * self.visible as f32
            * triangle.area()
            * TESTED_POINTS.map(share).iter().sum::<f32>()
    }
}

/// The error of texture coordinates that slid over the surface to `at`. Colours do not show it
/// where a texture repeats within a pixel, or is plain under a normal map.
fn slide_error(sample: &Sample, at: [f32; 2]) -> f32 {
    if sample.footprint <= 0.0 {
        return 0.0;
    }
    let [u, v] = [0, 1].map(|k| at[k] - sample.texture[k]);
    let squared_pixels = (u * u + v * v) / sample.footprint;
    (SLIDE * squared_pixels).min(1.0) * sample.power
}

/// The weighted errors of four samples by the distances of their nearest points, times the mean
/// squares of their colours (`power`), since black differs least from a background. A sample is
/// uncovered as far as its nearest point lies beside it, not above or below; wholly from its extent
/// on. To that comes the area that covers another layer, or is covered by it.
pub(super) fn geometric_error(
    quad: &SampleQuad,
    nearest: &NearestPoints,
    distance_weight: f32,
) -> Vec4 {
    let NearestPoints { away, squared, .. } = *nearest;
    let along = away.dot(quad.normal);
    let beside = (squared - along * along).max(Vec4::ZERO).sqrt();
    let is_covered = beside.cmplt(quad.extent);
    let extent = Vec4::select(is_covered, quad.extent, Vec4::ONE);
    let uncovered = Vec4::select(is_covered, beside / extent, Vec4::ONE);
    let silhouette = SILHOUETTE * quad.curvature * squared.sqrt();
    let error = distance_weight * squared + silhouette + UNCOVERED * uncovered;
    let error = quad.weight * error.min(Vec4::splat(MAX_GEOMETRY)) * quad.power;
    let towards = -along * quad.inverse_rest.signum();
    let covering = ((towards - quad.free) * quad.inverse_rest.abs()).clamp(Vec4::ZERO, Vec4::ONE);
    error + COVERING * quad.extent * quad.extent * covering
}
