//! Squared distances of samples for each face of the level that they are tied to: where a refit has
//! made a level worse.

use lodc_mesh::DisjointSets;

/// A component of a level has gained too little from a refit if more than this share of its energy
/// is left. Chosen by hand.
const MAX_REMAINING: f64 = 0.9;

/// Squared distances of the samples that are tied to each face of a level.
#[derive(Clone, Debug)]
pub(crate) struct FaceDistances {
    /// The largest squared distance of each face.
    max_squared: Vec<f64>,
    /// The sum of squared distances of each face, by the samples' weights.
    energy: Vec<f64>,
}

impl FaceDistances {
    pub(crate) fn new(face_count: usize) -> Self {
        Self { max_squared: vec![0.0; face_count], energy: vec![0.0; face_count] }
    }

    /// Adds a sample that is tied to a face.
    pub(crate) fn add(&mut self, face: u32, weight: f64, squared: f64) {
        let face = face as usize;
        self.energy[face] += weight * squared;
        self.max_squared[face] = self.max_squared[face].max(squared);
    }

    /// The largest squared distance of a face.
    pub(crate) fn max_squared_of(&self, face: usize) -> f64 {
        self.max_squared[face]
    }

    /// The largest squared distance of all faces.
    pub(crate) fn max_squared(&self) -> f64 {
        self.max_squared.iter().copied().fold(0.0, f64::max)
    }

    /// The energies of the faces around each point, added up.
    pub(crate) fn energies_around(&self, faces: &[[u32; 3]], point_count: usize) -> Vec<f64> {
        let mut energies = vec![0.0; point_count];
        for (face, energy) in faces.iter().zip(&self.energy) {
            face.iter().for_each(|&p| energies[p as usize] += energy);
        }
        energies
    }
}

/// Returns for each point whether its component of the level comes barely closer than at `first`,
/// even if every point that gets worse stays where it was. `first` and `now` are energies around
/// points.
///
/// Where most points of a component are held back, moves of the others gain next to nothing, and
/// may be large: spikes.
pub(crate) fn barely_closer(first: &[f64], now: &[f64], faces: &[[u32; 3]]) -> Vec<bool> {
    let mut components = DisjointSets::new(first.len());
    for &[a, b, c] in faces {
        components.join(a, b);
        components.join(a, c);
    }
    let mut sums = vec![[0.0; 2]; first.len()];
    for ((p, at_start), now) in (0..).zip(first).zip(now) {
        let sum: &mut [f64; 2] = &mut sums[components.find(p) as usize];
        *sum = [sum[0] + at_start, sum[1] + now.min(*at_start)];
    }
    (0..first.len() as u32)
        .map(|p| sums[components.find(p) as usize])
        .map(|[at_start, now]| now > MAX_REMAINING * at_start)
        .collect()
}

/// Returns the sum of energies around points if every point that is worse than at `first` stays.
pub(crate) fn energy_if_worse_stay(first: &[f64], now: &[f64]) -> f64 {
    first.iter().zip(now).map(|(a, b)| a.min(*b)).sum()
}
