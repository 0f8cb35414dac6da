//! Segments with a radius around long triangles that lie askew. The boxes of a fan of slivers all
//! lie over each other near its middle; their capsules do not.

use glam::DVec3;

/// What is within a radius of a segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Capsule {
    ends: [[f32; 3]; 2],
    radius: f32,
}

/// A capsule is of use if its radius is below this share of its length. Chosen by hand.
const MAX_RADIUS_SHARE: f64 = 0.2;

impl Capsule {
    /// That of everything.
    pub(crate) const ALL: Self = Self { ends: [[0.0; 3]; 2], radius: f32::INFINITY };

    /// Returns a capsule around some triangles along the mean of their longest edges;
    /// [`Self::ALL`] if that would be of no use.
    pub(crate) fn around(triangles: impl Iterator<Item = [[f32; 3]; 3]> + Clone) -> Self {
        let to_dvec3 = |p: [f32; 3]| DVec3::from(p.map(f64::from));
        let corners = triangles.clone().map(|t| t.map(to_dvec3));
        let (mut axis, mut middle, mut count) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for [a, b, c] in corners.clone() {
            let edges = [b - a, c - b, a - c];
            let longest = edges.into_iter().fold(DVec3::ZERO, |longest, edge| {
                if edge.length_squared() > longest.length_squared() { edge } else { longest }
            });
            axis += if axis.dot(longest) < 0.0 { -longest } else { longest };
            middle += (a + b + c) / 3.0;
            count += 1.0;
        }
        let Some(axis) = axis.try_normalize() else { return Self::ALL };
        let middle = middle / count;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in corners.flatten() {
            let along = (p - middle).dot(axis);
            (low, high) = (low.min(along), high.max(along));
        }
        let ends = [low, high].map(|along| (middle + axis * along).to_array().map(|x| x as f32));
        let mut capsule = Self { ends, radius: 0.0 };
        triangles.for_each(|t| _ = capsule.include(&t));
        if f64::from(capsule.radius) < MAX_RADIUS_SHARE * (high - low) {
            capsule
        } else {
            Self::ALL
        }
    }

    pub(crate) fn is_all(&self) -> bool {
        self.radius == f32::INFINITY
    }

    /// Grows to include a triangle. Returns whether it has grown.
    pub(crate) fn include(&mut self, corners: &[[f32; 3]; 3]) -> bool {
        let distance = |p: &[f32; 3]| self.axis_distance(DVec3::from(p.map(f64::from)));
        let farthest = corners.iter().map(distance).fold(0.0, f64::max);
        if farthest <= f64::from(self.radius) {
            return false;
        }
        self.radius = (farthest as f32).next_up();
        true
    }

    /// Returns the distance of a point from the segment.
    fn axis_distance(&self, p: DVec3) -> f64 {
        let [a, b] = self.ends.map(|end| DVec3::from(end.map(f64::from)));
        let (edge, to_point) = (b - a, p - a);
        let length = edge.length_squared();
        let share = if length > 0.0 { (to_point.dot(edge) / length).clamp(0.0, 1.0) } else { 0.0 };
        (to_point - edge * share).length()
    }

    /// Returns a squared distance that no point of it is nearer than.
    pub(crate) fn distance_squared(&self, p: DVec3) -> f64 {
        if self.is_all() {
            return 0.0;
        }
        let distance = (self.axis_distance(p) - f64::from(self.radius)).max(0.0);
        distance * distance * (1.0 - 1e-9)
    }
}
