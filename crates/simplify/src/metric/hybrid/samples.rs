//! Samples of the input's surface. Each is in the list of the current face nearest to it; a list is
//! linked by indices.

use super::appearance::{Appearance, Colour, attribute_vertex};
use super::pixel::ShadingError;
use super::vectors::{mix, mix_coordinates};
use crate::cut::{Wedges, WorkingMesh};
use glam::Vec3;
use lodc_mesh::NONE;
use rayon::prelude::*;

/// Faces further apart than this (60°, as its cosine) are shaded as if an edge were between them:
/// as `compare` and other viewers shade meshes that come without normals.
pub(super) const CREASE: f32 = 0.5;

/// The most samples of one face; beyond, every other one is dropped and the rest weigh more. At a
/// limit of 16, webs between the rods of a wire chair went unseen.
const MAX_SAMPLES_PER_FACE: usize = 64;
/// Normals are averaged over at most this many faces, so that vertices of many faces take no
/// quadratic time. Chosen by hand: more than nearly any star has.
pub(super) const MAX_AVERAGED: usize = 64;

/// A point of the input's surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// In working units.
    pub(super) position: Vec3,
    /// The unit normal that the input is shaded with there.
    pub(super) normal: Vec3,
    /// The colour of the input there.
    pub(super) colour: Colour,
    /// The mean square of the colour's channels.
    pub(super) power: f32,
    /// Error of showing the colour of its current face at `at` instead of its own.
    pub(super) shading: ShadingError,
    /// Mean convex curvature of the input there: the inverse of a radius in working units.
    pub(super) curvature: f32,
    /// The area of texture space that a pixel covers there; 0 without texture coordinates.
    pub(super) footprint: f32,
    /// Texture coordinates there.
    pub(super) texture: [f32; 2],
    /// The area of the input that it represents, in squared working units, times its visible share.
    pub(super) weight: f32,
    /// Its nearest point on its current face: shares of the second and third corner.
    pub(super) at: [f32; 2],
    /// The weighted error by its distance from its face.
    pub(super) geometric: f32,
    /// The size of its piece of the input: the square root of the area.
    pub(super) extent: f32,
    /// The layer that it must not pass.
    pub(super) layer: Layer,
    /// The next sample in the list of its face; `NONE` at the end.
    next: u32,
}

/// Another layer of the input over or under a sample, as distances along its normal in working
/// units.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Layer {
    /// The distance that a sample may go to it at no cost.
    pub(super) free: f32,
    /// The inverse of what is then left to it, negative if it lies behind; 0 without a layer.
    pub(super) inverse_rest: f32,
}

impl Layer {
    /// A layer in front. It may have come to meet the sample: half of the way, but no farther than
    /// `most`.
    pub(super) fn in_front(distance: f32, most: f32) -> Self {
        let rest = (0.5 * distance).min(most).max(f32::MIN_POSITIVE);
        Self { free: distance - rest, inverse_rest: 1.0 / rest }
    }

    /// The same of a layer behind.
    pub(super) fn behind(distance: f32, most: f32) -> Self {
        let Self { free, inverse_rest } = Self::in_front(distance, most);
        Self { free, inverse_rest: -inverse_rest }
    }
}

/// All samples, in lists by face.
pub(super) struct Samples {
    all: Vec<Sample>,
    /// The first sample of each face; `NONE` without any.
    first: Vec<u32>,
    /// The energy of the part of each face that lies where the input has nothing.
    spurious: Vec<f32>,
    /// The number of faces at which the samples were last put in the order of their faces.
    sorted_at: u32,
}

impl Samples {
    /// Samples each face of the input: with one sample in its middle, or more if it is larger than
    /// the mean. A mesh of fewer than `least` faces gets about `least` samples in all. `pixel_area`
    /// is in squared working units.
    pub(super) fn new(
        mesh: &WorkingMesh,
        wedges: &Wedges,
        appearance: &Appearance<'_>,
        pixel_area: f32,
        least: u32,
    ) -> Self {
        let total: f64 = (0..mesh.faces.len() as u32).map(|f| f64::from(mesh.facet(f).area)).sum();
        let faces = mesh.faces.len().max(1) as f64;
        let sample_area = (total / faces.max(f64::from(least))) as f32;
        let normals: Vec<Vec3> = (0..mesh.group_positions.len() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .map(|g| area_normal(mesh, g))
            .collect();
        let area_normals = &normals[..];
        let sampled = SampledSurface { mesh, wedges, appearance, area_normals, pixel_area };
        let lists: Vec<Vec<Sample>> = (0..mesh.faces.len() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .map(|face| {
                let area = mesh.facet(face).area;
                let count = if sample_area > 0.0 { (area / sample_area) as usize } else { 1 };
                let count = count.clamp(1, MAX_SAMPLES_PER_FACE);
                sampled.samples(face, count)
            })
            .collect();
        let mut all: Vec<Sample> = Vec::with_capacity(lists.iter().map(Vec::len).sum());
        let mut first = Vec::with_capacity(lists.len());
        for list in lists {
            first.push(all.len() as u32);
            let n = list.len();
            for (i, mut s) in list.into_iter().enumerate() {
                if i + 1 < n {
                    s.next = all.len() as u32 + 1;
                }
                all.push(s);
            }
        }
        let sorted_at = mesh.live_faces;
        Self { all, spurious: vec![0.0; first.len()], first, sorted_at }
    }

    /// Whenever half of the faces are gone, puts the samples in the order of the faces that have
    /// them and drops those that no face has: lists that are contiguous are read faster.
    pub(super) fn sort(&mut self, mesh: &WorkingMesh) {
        if mesh.live_faces > self.sorted_at / 2 {
            return;
        }
        self.sorted_at = mesh.live_faces;
        let mut sorted: Vec<Sample> = Vec::new();
        for first in &mut self.first {
            let mut at = std::mem::replace(first, NONE);
            if at != NONE {
                *first = sorted.len() as u32;
            }
            while at != NONE {
                let sample = self.all[at as usize];
                at = sample.next;
                let next = if at == NONE { NONE } else { sorted.len() as u32 + 1 };
                sorted.push(Sample { next, ..sample });
            }
        }
        self.all = sorted;
    }

    /// Multiplies the weight of every sample of the input by a factor of its position and of the
    /// unit normal of its face.
    pub(super) fn scale_weights(
        &mut self,
        mesh: &WorkingMesh,
        factor: impl Fn(Vec3, Vec3) -> f32 + Sync,
    ) {
        // Samples are still in the order of their faces.
        let first = &self.first;
        self.all.par_iter_mut().enumerate().with_min_len(1024).for_each(|(i, s)| {
            let face = first.partition_point(|&start| start as usize <= i) - 1;
            s.weight *= factor(s.position, mesh.normal(face as u32));
        });
    }

    /// All samples of the input.
    pub(super) fn all(&self) -> &[Sample] {
        &self.all
    }

    /// Stores the layer of every sample of the input.
    pub(super) fn set_layers(&mut self, layers: Vec<Layer>) {
        self.all.iter_mut().zip(layers).for_each(|(sample, layer)| sample.layer = layer);
    }

    /// The sum of all weights, in squared working units.
    #[cfg(test)]
    pub(super) fn weight(&self) -> f32 {
        self.all.iter().map(|s| s.weight).sum()
    }

    pub(super) fn get(&self, sample: u32) -> &Sample {
        &self.all[sample as usize]
    }

    /// The samples of a face.
    pub(super) fn of(&self, face: u32) -> impl Iterator<Item = u32> + '_ {
        let mut at = self.first[face as usize];
        std::iter::from_fn(move || {
            let sample = at;
            at = self.all.get(sample as usize)?.next;
            Some(sample)
        })
    }

    /// The energy of a face's part that lies where the input has nothing.
    pub(super) fn spurious(&self, face: u32) -> f32 {
        self.spurious[face as usize]
    }

    /// Stores that energy.
    pub(super) fn set_spurious(&mut self, face: u32, spurious: f32) {
        self.spurious[face as usize] = spurious;
    }

    /// Empties the list of a face.
    pub(super) fn clear(&mut self, face: u32) {
        self.first[face as usize] = NONE;
    }

    /// Gives a sample to a face, at shares of its second and third corner, with its weighted error
    /// by distance and its error by shading.
    pub(super) fn put(
        &mut self,
        sample: u32,
        face: u32,
        at: [f32; 2],
        geometric: f32,
        shading: ShadingError,
    ) {
        let next = std::mem::replace(&mut self.first[face as usize], sample);
        let s = &mut self.all[sample as usize];
        (s.at, s.geometric, s.shading, s.next) = (at, geometric, shading, next);
    }

    /// Drops every other sample of a face that has too many. The others take over their weight.
    pub(super) fn thin(&mut self, face: u32) {
        if self.of(face).count() <= MAX_SAMPLES_PER_FACE {
            return;
        }
        let (mut all, mut kept) = (0.0, 0.0);
        for (i, s) in self.of(face).enumerate() {
            let weight = self.get(s).weight;
            all += weight;
            kept += if i % 2 == 0 { weight } else { 0.0 };
        }
        let scale = if kept > 0.0 { all / kept } else { 1.0 };
        let mut at = self.first[face as usize];
        while at != NONE {
            let s = &mut self.all[at as usize];
            s.weight *= scale;
            s.geometric *= scale;
            s.extent *= std::f32::consts::SQRT_2;
            let dropped = s.next;
            let next = self.all.get(dropped as usize).map_or(NONE, |d| d.next);
            self.all[at as usize].next = next;
            at = next;
        }
    }
}

/// The surface of the input while it is sampled.
struct SampledSurface<'a> {
    mesh: &'a WorkingMesh,
    wedges: &'a Wedges,
    appearance: &'a Appearance<'a>,
    /// The mean normal around each group, by area.
    area_normals: &'a [Vec3],
    /// In squared working units.
    pixel_area: f32,
}

impl SampledSurface<'_> {
    /// `count` samples of one face.
    fn samples(&self, face: u32, count: usize) -> Vec<Sample> {
        let Self { mesh, wedges, appearance, area_normals, pixel_area } = *self;
        let f = &mesh.faces[face as usize];
        let facet = mesh.facet(face);
        let corners = mesh.wedges(face);
        let vertices = corners.map(|w| attribute_vertex(wedges, w));
        let submesh = wedges.submesh(corners[0]);
        let smooth_normal = |g: u32| {
            let faces = mesh.star(g).iter().take(MAX_AVERAGED);
            let normals = faces.map(|c| mesh.normal(c.face()));
            normals.filter(|n| n.dot(facet.normal) > CREASE).sum::<Vec3>().normalize_or_zero()
        };
        let normals = if appearance.has_normals() {
            vertices.map(|v| appearance.normal(v))
        } else {
            f.groups.map(smooth_normal)
        };
        let positions = f.groups.map(|g| mesh.position(g).as_vec3());
        let curvature = convex_curvature(f.groups.map(|g| area_normals[g as usize]), &positions);
        let uv = vertices.map(|v| appearance.coordinates(v));
        let [b, c] = [1, 2].map(|i| [0, 1].map(|k| uv[i][k] - uv[0][k]));
        let uv_area = 0.5 * (b[0] * c[1] - b[1] * c[0]).abs();
        let footprint = if facet.area > 0.0 { uv_area / facet.area * pixel_area } else { 0.0 };
        (0..count)
            .map(|i| {
                let at = if count == 1 { [1.0 / 3.0; 2] } else { spread(i, count) };
                let texture = mix_coordinates(&uv, at);
                let colour = appearance.colour(submesh, vertices, at, texture, footprint);
                Sample {
                    position: mix(&positions, at),
                    normal: mix(&normals, at).normalize_or_zero(),
                    colour,
                    power: colour.power(),
                    shading: ShadingError::of_own_colour(colour.power()),
                    curvature,
                    footprint,
                    texture,
                    weight: facet.area / count as f32,
                    at,
                    geometric: 0.0,
                    extent: (facet.area / count as f32).sqrt(),
                    layer: Layer::default(),
                    next: NONE,
                }
            })
            .collect()
    }
}

/// The unit mean of the normals around a group, by area; zero if they cancel.
fn area_normal(mesh: &WorkingMesh, group: u32) -> Vec3 {
    let faces = mesh.star(group).iter().map(|c| mesh.facet(c.face()));
    faces.map(|f| f.normal * f.area).sum::<Vec3>().normalize_or_zero()
}

/// The mean curvature along a face's edges, as inverse of a radius: the difference of the normals
/// at their ends per length, 0 for edges that do not bulge outwards.
fn convex_curvature(normals: [Vec3; 3], p: &[Vec3; 3]) -> f32 {
    let along = |i: usize, j: usize| {
        let edge = p[j] - p[i];
        let length = edge.length_squared();
        if length > 0.0 { ((normals[j] - normals[i]).dot(edge) / length).max(0.0) } else { 0.0 }
    };
    (along(0, 1) + along(1, 2) + along(2, 0)) / 3.0
}

/// The `i`-th of `count` points spread over a triangle, as shares of its second and third corner:
/// evenly by area away from the first corner, by the golden ratio across.
fn spread(i: usize, count: usize) -> [f32; 2] {
    let u = (i as f32 + 0.5) / count as f32;
    let v = (0.5 + i as f32 * 0.618_034).fract();
    let r = u.sqrt();
    [r * (1.0 - v), r * v]
}
