//! How far samples reach: around each of them the input is near.

use super::samples::{Sample, Samples};
use glam::{Vec3, Vec4};

/// The input is near where a sample is nearer than this many times its extent.
const NEAR: f32 = 1.5;

/// Four samples: where they are, and the squares of how far they reach. Those that are missing are
/// infinitely far away.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    x: Vec4,
    y: Vec4,
    z: Vec4,
    squared: Vec4,
}

impl Reach {
    pub(super) fn new(four: &[u32], samples: &Samples) -> Self {
        let lanes = |value: fn(&Sample) -> f32, missing: f32| {
            let lane = |i: usize| four.get(i).map_or(missing, |&s| value(samples.get(s)));
            Vec4::new(lane(0), lane(1), lane(2), lane(3))
        };
        let squared = |s: &Sample| (NEAR * NEAR * s.extent * s.extent).max(f32::MIN_POSITIVE);
        Self {
            x: lanes(|s| s.position.x, f32::INFINITY),
            y: lanes(|s| s.position.y, f32::INFINITY),
            z: lanes(|s| s.position.z, f32::INFINITY),
            squared: lanes(squared, 1.0),
        }
    }

    /// The squared distances of a place, as shares of the squared reaches.
    #[inline]
    pub(super) fn shares(&self, place: Vec3) -> Vec4 {
        let (x, y, z) = (self.x - place.x, self.y - place.y, self.z - place.z);
        (x * x + y * y + z * z) / self.squared
    }
}
