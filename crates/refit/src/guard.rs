//! The guard of a refit's step: limits moves so that no face turns over or collapses.

use crate::level::Level;
use glam::DVec3;

/// Cosine of the angle by which a face may turn: about 75°. Chosen by hand.
const MIN_COSINE: f64 = 0.25;
/// Share of its area that a face keeps at least. Chosen by hand.
const MIN_AREA_SHARE: f64 = 0.02;
/// Number of times that the moves of a face's corners are halved before they are given up. Chosen
/// by hand.
const HALVINGS: usize = 5;

/// References that a step is measured against.
pub(crate) struct Guard<'a> {
    pub(crate) level: &'a Level,
    /// Normals of the faces where the simplifier left them.
    pub(crate) first_normals: &'a [DVec3],
    /// Mean normals of the input where each face lies; zero where there is none.
    pub(crate) input_normals: &'a [DVec3],
}

impl Guard<'_> {
    /// Returns `from` moved by as much of `moves` as spoils no face.
    pub(crate) fn limit(&self, from: &[DVec3], moves: &[DVec3]) -> Vec<DVec3> {
        let crosses_before: Vec<DVec3> = self.level.corners(from).into_iter().map(cross).collect();
        let mut share = vec![1.0f64; from.len()];
        let mut round = 0;
        loop {
            let to: Vec<DVec3> = (from.iter().zip(moves).zip(&share))
                .map(|((&p, &m), &s)| if s > 0.0 { p + m * s } else { p })
                .collect();
            let spoilt: Vec<usize> = (0..crosses_before.len())
                .filter(|&f| self.is_spoilt(f, crosses_before[f], &to))
                .collect();
            if spoilt.is_empty() {
                return to;
            }
            let mut held = false;
            let mut corners: Vec<u32> = spoilt.iter().flat_map(|&f| self.level.faces[f]).collect();
            corners.sort_unstable();
            corners.dedup();
            for p in corners {
                let share = &mut share[p as usize];
                held |= *share > 0.0;
                *share = if round < HALVINGS { *share / 2.0 } else { 0.0 };
            }
            if !held {
                // Nothing moves there: rounding alone made them look spoilt.
                return to;
            }
            round += 1;
        }
    }

    fn is_spoilt(&self, face: usize, cross_before: DVec3, to: &[DVec3]) -> bool {
        let now = cross(self.level.faces[face].map(|p| to[p as usize]));
        if now == cross_before {
            return false;
        }
        let (normal, old) = (now.normalize_or_zero(), cross_before.normalize_or_zero());
        let first = self.first_normals[face];
        let input = self.input_normals[face];
        let turned = |reference: DVec3| {
            let cosine = normal.dot(reference);
            reference != DVec3::ZERO && cosine < MIN_COSINE && cosine < old.dot(reference)
        };
        now.length() < MIN_AREA_SHARE * cross_before.length() || turned(first) || turned(input)
    }
}

/// Twice the area of a triangle along its normal.
pub(crate) fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}
