//! Squared distances of samples, summed and maximised by the face of the level that each is tied
//! to: tells which parts of a level a refit has made worse.

use crate::system::Tie;
use lodc_mesh::DisjointSets;

/// The share of its squared distance above which a part of a level has gained too little from a
/// refit. Chosen by hand.
const MAX_REMAINING: f64 = 0.9;

/// Squared distances of the samples that are tied to each face of a level.
#[derive(Clone, Debug)]
pub(crate) struct ByFace {
    /// The largest.
    farthest: Vec<f64>,
    /// The sum by weight.
    energy: Vec<f64>,
}

impl ByFace {
    pub(crate) fn new(faces: usize) -> Self {
        Self { farthest: vec![0.0; faces], energy: vec![0.0; faces] }
    }

    /// Adds a sample.
    pub(crate) fn add(&mut self, tie: &Tie, squared: f64) {
        let face = tie.face as usize;
        self.energy[face] += tie.weight * squared;
        self.farthest[face] = self.farthest[face].max(squared);
    }

    /// The largest squared distance of a face.
    pub(crate) fn farthest_of(&self, face: usize) -> f64 {
        self.farthest[face]
    }

    /// The largest squared distance of all faces.
    pub(crate) fn farthest(&self) -> f64 {
        self.farthest.iter().copied().fold(0.0, f64::max)
    }

    /// The energies of the faces around each point, added up.
    pub(crate) fn around(&self, faces: &[[u32; 3]], points: usize) -> Vec<f64> {
        let mut around = vec![0.0; points];
        for (face, energy) in faces.iter().zip(&self.energy) {
            face.iter().for_each(|&p| around[p as usize] += energy);
        }
        around
    }
}

/// Returns for each point whether its part of a level (its connected faces) comes hardly closer
/// than at `first`, even if every point that comes farther stays where it was. `first` and `now`
/// are energies [around] points.
///
/// Where most points of a part are held back, the others make the best of it: they may end up
/// far from where they were, as spikes, for next to nothing.
///
/// [around]: ByFace::around
pub(crate) fn hardly_closer(first: &[f64], now: &[f64], faces: &[[u32; 3]]) -> Vec<bool> {
    let mut parts = DisjointSets::new(first.len());
    for &[a, b, c] in faces {
        parts.join(a, b);
        parts.join(a, c);
    }
    let mut sums = vec![[0.0; 2]; first.len()];
    for ((p, at_start), now) in (0..).zip(first).zip(now) {
        let sum: &mut [f64; 2] = &mut sums[parts.find(p) as usize];
        *sum = [sum[0] + at_start, sum[1] + now.min(*at_start)];
    }
    let of_part = |p: u32| sums[parts.find(p) as usize];
    (0..first.len() as u32)
        .map(of_part)
        .map(|[at_start, now]| now > MAX_REMAINING * at_start)
        .collect()
}

/// The sum of energies around points if every point that comes farther than at `first` stays.
pub(crate) fn within_reach(first: &[f64], now: &[f64]) -> f64 {
    first.iter().zip(now).map(|(a, b)| a.min(*b)).sum()
}
