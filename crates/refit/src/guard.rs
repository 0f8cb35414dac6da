//! Limits moves of points so that no face turns over or becomes degenerate.

use crate::level::CoarseMesh;
use glam::DVec3;

/// Cosine of the angle by which a face may turn: about 75°. Chosen by hand.
const MIN_COSINE: f64 = 0.25;
/// Share of its area that a face keeps at least. Chosen by hand.
const MIN_AREA_SHARE: f64 = 0.02;
/// Number of times that the moves of a face's corners are halved before they are left out. Chosen
/// by hand.
const MAX_HALVINGS: usize = 5;

/// What faces are compared with when their points have moved.
pub(crate) struct Guard<'a> {
    pub(crate) level: &'a CoarseMesh,
    /// Normals of the faces where the simplifier left them.
    pub(crate) first_normals: &'a [DVec3],
    /// The mean normal of the input near each face; zero where there is none.
    pub(crate) input_normals: &'a [DVec3],
}

impl Guard<'_> {
    /// Returns the positions `from` moved by as much of `moves` as spoils no face.
    pub(crate) fn limit(&self, from: &[DVec3], moves: &[DVec3]) -> Vec<DVec3> {
        let crosses_before: Vec<DVec3> = self.level.corners(from).into_iter().map(cross).collect();
        let mut shares = vec![1.0f64; from.len()];
        let mut round = 0;
        loop {
            let to: Vec<DVec3> = (from.iter().zip(moves).zip(&shares))
                .map(|((&p, &m), &s)| if s > 0.0 { p + m * s } else { p })
                .collect();
            let spoilt: Vec<usize> = (0..crosses_before.len())
                .filter(|&f| self.is_spoilt(f, crosses_before[f], &to))
                .collect();
            if spoilt.is_empty() {
                return to;
            }
            let mut any_reduced = false;
            let mut corners: Vec<u32> = spoilt.iter().flat_map(|&f| self.level.faces[f]).collect();
            corners.sort_unstable();
            corners.dedup();
            for p in corners {
                let share = &mut shares[p as usize];
                any_reduced |= *share > 0.0;
                *share = if round < MAX_HALVINGS { *share / 2.0 } else { 0.0 };
            }
            if !any_reduced {
                // None of them moves: rounding alone makes the faces look spoilt.
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
        let (normal, normal_before) = (now.normalize_or_zero(), cross_before.normalize_or_zero());
        let turns_from = |reference: DVec3| {
            let cosine = normal.dot(reference);
            reference != DVec3::ZERO && cosine < MIN_COSINE && cosine < normal_before.dot(reference)
        };
        now.length() < MIN_AREA_SHARE * cross_before.length()
            || turns_from(self.first_normals[face])
            || turns_from(self.input_normals[face])
    }
}

/// Returns the normal of a triangle, as long as twice its area.
pub(crate) fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}
