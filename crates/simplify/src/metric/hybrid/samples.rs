//! Samples of the input's surface, each kept with the face that stands for its place now.

use crate::working::{Face, Working};
use glam::Vec3;
use rayon::prelude::*;

pub(super) const NONE: u32 = u32::MAX;

/// Faces further apart than this (60°, as its cosine) are shaded as if an edge were between them.
pub(super) const CREASE: f32 = 0.5;

/// No face keeps more samples than this; the rest are dropped and the others count for more.
const MOST: usize = 16;

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
    next: u32,
}

/// All samples, in lists by face.
pub(super) struct Samples {
    all: Vec<Sample>,
    first: Vec<u32>,
}

impl Samples {
    /// One sample in the middle of each face of the input.
    pub(super) fn new(mesh: &Working) -> Self {
        let sample = |f: &Face| {
            let own = f.normal;
            let corner_normal = |g: u32| {
                let normals = mesh.star(g).iter().map(|c| mesh.faces[c.face() as usize].normal);
                normals.filter(|n| n.dot(own) > CREASE).sum::<Vec3>().normalize_or_zero()
            };
            let [p, q, r] = f.groups.map(|g| mesh.position(g));
            Sample {
                position: ((p + q + r) / 3.0).as_vec3(),
                normal: f.groups.map(corner_normal).into_iter().sum::<Vec3>().normalize_or_zero(),
                weight: f.area,
                at: [1.0 / 3.0; 2],
                distance: 0.0,
                next: NONE,
            }
        };
        let all: Vec<Sample> = mesh.faces.par_iter().with_min_len(1024).map(sample).collect();
        let first = (0..all.len() as u32).collect();
        Self { all, first }
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

    /// Takes all samples from a face.
    pub(super) fn clear(&mut self, face: u32) {
        self.first[face as usize] = NONE;
    }

    /// Gives a sample to a face.
    pub(super) fn put(&mut self, sample: u32, face: u32, at: [f32; 2], distance: f32) {
        let next = std::mem::replace(&mut self.first[face as usize], sample);
        let s = &mut self.all[sample as usize];
        (s.at, s.distance, s.next) = (at, distance, next);
    }

    /// Drops every other sample of a face that has too many. Those that stay take over the weight of those that go.
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
            let dropped = s.next;
            let next = self.all.get(dropped as usize).map_or(NONE, |d| d.next);
            self.all[at as usize].next = next;
            at = next;
        }
    }
}
