//! Quadric error in vertex-centred form (Garland and Heckbert 1997, rewritten so that nothing
//! cancels).
//!
//! A quadric belongs to a point and is stored relative to it: `Q(δ) = δᵀAδ + 2b·δ + c` is the
//! weighted sum of squared distances of the point moved by `δ` to the planes it stands for. A new
//! quadric has planes through its own point only, so `b` and `c` start as zero and there is no
//! large number to subtract from another.

use glam::DVec3;

/// A symmetric 3×3 matrix: xx, xy, xz, yy, yz, zz.
pub(crate) type Symmetric = [f64; 6];

/// Adds `weight · v vᵀ`.
#[inline]
pub(crate) fn add_outer(a: &mut Symmetric, v: DVec3, weight: f64) {
    let w = v * weight;
    a[0] += w.x * v.x;
    a[1] += w.x * v.y;
    a[2] += w.x * v.z;
    a[3] += w.y * v.y;
    a[4] += w.y * v.z;
    a[5] += w.z * v.z;
}

/// `A v`.
#[inline]
pub(crate) fn times(a: &Symmetric, v: DVec3) -> DVec3 {
    DVec3::new(
        a[0] * v.x + a[1] * v.y + a[2] * v.z,
        a[1] * v.x + a[3] * v.y + a[4] * v.z,
        a[2] * v.x + a[4] * v.y + a[5] * v.z,
    )
}

/// A vertex-centred quadric with the weight of its planes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Quadric {
    pub(crate) a: Symmetric,
    pub(crate) b: DVec3,
    pub(crate) c: f64,
    pub(crate) weight: f64,
}

impl Quadric {
    /// Adds a plane through the quadric's point.
    pub(crate) fn add_plane(&mut self, unit_normal: DVec3, weight: f64) {
        add_outer(&mut self.a, unit_normal, weight);
        self.weight += weight;
    }

    /// Its value with the point moved by `delta`; never negative.
    #[inline]
    pub(crate) fn at(&self, delta: DVec3) -> f64 {
        (delta.dot(times(&self.a, delta) + 2.0 * self.b) + self.c).max(0.0)
    }

    /// The same quadric, relative to its point moved by `delta`.
    pub(crate) fn transported(&self, delta: DVec3) -> Self {
        Self { c: self.at(delta), b: self.b + times(&self.a, delta), ..*self }
    }

    /// Adds another quadric of the same point.
    pub(crate) fn add(&mut self, other: &Self) {
        for (a, o) in self.a.iter_mut().zip(other.a) {
            *a += o;
        }
        self.b += other.b;
        self.c += other.c;
        self.weight += other.weight;
    }

    /// Root mean square distance of the point to the planes.
    pub(crate) fn distance(&self) -> f64 {
        if self.weight > 0.0 { (self.c / self.weight).sqrt() } else { 0.0 }
    }
}

#[cfg(test)]
#[path = "quadrics_tests.rs"]
mod tests;
