//! Samples of the input's surface, each kept with the face that stands for its place now.

use crate::working::{Facet, WorkingMesh};
use glam::Vec3;
use rayon::prelude::*;

pub(super) const NONE: u32 = u32::MAX;

/// Faces further apart than this (60°, as its cosine) are shaded as if an edge were between them.
pub(super) const CREASE: f32 = 0.5;

/// No face keeps more samples than this; the rest are dropped and the others count for more.
const MOST: usize = 64;
/// A face of the input has at most this many samples; one of mean area or less has one.
const DENSEST: usize = 16;

/// A place on the input's surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// In working units.
    pub(super) position: Vec3,
    /// The unit normal that the input is shaded with there.
    pub(super) normal: Vec3,
    /// The area it stands for, as far as it is seen.
    pub(super) weight: f32,
    /// Where it lies in its face: shares of the second and third corner.
    pub(super) at: [f32; 2],
    /// What its distance from its face counts for.
    pub(super) distance: f32,
    /// The size of the piece that it stands for: the square root of its area.
    pub(super) extent: f32,
    next: u32,
}

/// All samples, in lists by face.
pub(super) struct Samples {
    all: Vec<Sample>,
    first: Vec<u32>,
    /// What each face counts for that lies where the input has nothing.
    foreign: Vec<f32>,
}

impl Samples {
    /// Samples of each face of the input: one in its middle, more on faces that are larger than the
    /// mean.
    pub(super) fn new(mesh: &WorkingMesh) -> Self {
        let faces = mesh.faces.len() as u32;
        let total: f64 = (0..faces).map(|f| f64::from(mesh.facet(f).area)).sum();
        let mean = (total / mesh.faces.len().max(1) as f64) as f32;
        let samples = |face: u32| {
            let (f, Facet { normal: own, area }) = (&mesh.faces[face as usize], mesh.facet(face));
            let corner_normal = |g: u32| {
                let normals = mesh.star(g).iter().map(|c| mesh.normal(c.face()));
                normals.filter(|n| n.dot(own) > CREASE).sum::<Vec3>().normalize_or_zero()
            };
            let p = f.groups.map(|g| mesh.position(g).as_vec3());
            let normals = f.groups.map(corner_normal);
            let count = if mean > 0.0 { ((area / mean) as usize).clamp(1, DENSEST) } else { 1 };
            (0..count)
                .map(|i| {
                    let [u, v] = if count == 1 { [1.0 / 3.0; 2] } else { place(i, count) };
                    let mix = |a: [Vec3; 3]| a[0] * (1.0 - u - v) + a[1] * u + a[2] * v;
                    Sample {
                        position: mix(p),
                        normal: mix(normals).normalize_or_zero(),
                        weight: area / count as f32,
                        at: [u, v],
                        distance: 0.0,
                        extent: (area / count as f32).sqrt(),
                        next: NONE,
                    }
                })
                .collect::<Vec<Sample>>()
        };
        let lists: Vec<Vec<Sample>> =
            (0..faces).into_par_iter().with_min_len(1024).map(samples).collect();
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
        Self { all, foreign: vec![0.0; first.len()], first }
    }

    /// Every sample, for weighing them.
    pub(super) fn all_mut(&mut self) -> &mut [Sample] {
        &mut self.all
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

    /// What a face counts for that lies where the input has nothing.
    pub(super) fn foreign(&self, face: u32) -> f32 {
        self.foreign[face as usize]
    }

    /// Notes that.
    pub(super) fn set_foreign(&mut self, face: u32, foreign: f32) {
        self.foreign[face as usize] = foreign;
    }

    /// Takes all samples from a face.
    pub(super) fn clear(&mut self, face: u32) {
        self.first[face as usize] = NONE;
    }

    /// Gives a sample to a face. `distance` is what its distance counts for.
    pub(super) fn put(&mut self, sample: u32, face: u32, at: [f32; 2], distance: f32) {
        let next = std::mem::replace(&mut self.first[face as usize], sample);
        let s = &mut self.all[sample as usize];
        (s.at, s.distance, s.next) = (at, distance, next);
    }

    /// Drops every other sample of a face that has too many. Those that stay take over the weight
    /// of those that go.
    pub(super) fn thin(&mut self, face: u32) {
        if self.of(face).count() <= MOST {
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
            s.distance *= scale;
            s.extent *= std::f32::consts::SQRT_2;
            let dropped = s.next;
            let next = self.all.get(dropped as usize).map_or(NONE, |d| d.next);
            self.all[at as usize].next = next;
            at = next;
        }
    }
}

/// The `i`-th of `count` places spread over a triangle, as shares of its second and third corner:
/// evenly by area along one way, by the golden ratio along the other.
fn place(i: usize, count: usize) -> [f32; 2] {
    let u = (i as f32 + 0.5) / count as f32;
    let v = (0.5 + i as f32 * 0.618_034).fract();
    let r = u.sqrt();
    [r * (1.0 - v), r * v]
}
