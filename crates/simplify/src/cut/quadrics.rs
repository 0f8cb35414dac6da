//! Quadric error in vertex-centred form (Garland and Heckbert 1997, rewritten so that nothing
//! cancels).
//!
//! A quadric belongs to a point and is stored relative to it: `Q(δ) = δᵀAδ + 2b·δ + c` is the
//! weighted sum of squared distances of the point moved by `δ` to its planes. A new
//! quadric has planes through its own point only, so `b` and `c` start as zero and there is no
//! large number to subtract from another.

use super::mesh::{Facet, WorkingMesh};
use super::neighbourhood::Neighbourhood;
use glam::DVec3;
use lodc_mesh::NONE;

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
    /// `A`, `b` and `c` of the module.
    pub(crate) a: Symmetric,
    pub(crate) b: DVec3,
    pub(crate) c: f64,
    /// The sum of the planes' weights.
    weight: f64,
}

impl Quadric {
    /// Adds a plane through the quadric's point.
    pub(super) fn add_plane(&mut self, unit_normal: DVec3, weight: f64) {
        add_outer(&mut self.a, unit_normal, weight);
        self.weight += weight;
    }

    /// Adds the plane of a face with a corner at the quadric's point.
    pub(super) fn add_facet(&mut self, facet: &Facet) {
        self.add_plane(facet.normal.as_dvec3(), f64::from(facet.area));
    }

    /// Its value with the point moved by `delta`; never negative.
    #[inline]
    fn at(&self, delta: DVec3) -> f64 {
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

/// Accumulated quadrics, one per group of a region.
#[derive(Default)]
pub(crate) struct Quadrics {
    /// Planes of the input's faces.
    pub(crate) surface: Vec<Quadric>,
    /// Planes along the input's borders, for the few groups that have any.
    pub(crate) border: Vec<Quadric>,
    /// The index in `border` for each group, [`NONE`] for one that has none; empty if no group has.
    pub(crate) border_of: Vec<u32>,
}

impl Quadrics {
    /// The quadrics of the input's surface for the first `own` groups of a region.
    pub(super) fn new(mesh: &WorkingMesh, own: usize) -> Self {
        let mut surface = vec![Quadric::default(); own];
        for f in 0..mesh.faces.len() as u32 {
            let facet = mesh.facet(f);
            for &g in mesh.faces[f as usize].groups.iter().filter(|&&g| (g as usize) < own) {
                surface[g as usize].add_facet(&facet);
            }
        }
        Self { surface, ..Self::default() }
    }

    /// Empties all lists, which keep their capacity.
    pub(super) fn clear(&mut self) {
        self.surface.clear();
        self.border.clear();
        self.border_of.clear();
    }

    /// The border quadric of a group.
    #[inline]
    pub(crate) fn border(&self, group: u32) -> Option<&Quadric> {
        let at = *self.border_of.get(group as usize)?;
        self.border.get(at as usize)
    }

    /// Gives a group of the input its border quadric, if it is at a border.
    pub(super) fn add_border(&mut self, group: u32, around: &Neighbourhood) {
        if around.borders == 0 {
            return;
        }
        let mut quadric = Quadric::default();
        for plane in &around.planes {
            quadric.add_plane(plane.normal, plane.weight);
        }
        if quadric.weight > 0.0 {
            self.set_border(group, quadric);
        }
    }

    /// Gives a group, which has none, a border quadric.
    pub(super) fn set_border(&mut self, group: u32, quadric: Quadric) {
        if self.border_of.is_empty() {
            self.border_of = vec![NONE; self.surface.len()];
            self.border.reserve(self.surface.len() / 4);
        }
        self.border_of[group as usize] = self.border.len() as u32;
        self.border.push(quadric);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum of weighted squared distances of a point to planes given by point and normal.
    fn direct(planes: &[(DVec3, DVec3, f64)], x: DVec3) -> f64 {
        planes.iter().map(|&(p, n, w)| w * n.dot(x - p).powi(2)).sum()
    }

    #[test]
    fn transport_and_addition_give_the_sum_of_squared_distances() {
        let (p, q) = (DVec3::new(0.3, -1.0, 2.0), DVec3::new(1.0, 0.5, -0.25));
        let planes = [
            (p, DVec3::new(0.6, 0.8, 0.0), 2.0),
            (p, DVec3::new(0.0, 0.6, -0.8), 0.5),
            (q, DVec3::X, 3.0),
            (q, DVec3::new(0.0, -0.28, 0.96), 1.0),
        ];
        let mut at_p = Quadric::default();
        let mut at_q = Quadric::default();
        planes[..2].iter().for_each(|&(_, n, w)| at_p.add_plane(n, w));
        planes[2..].iter().for_each(|&(_, n, w)| at_q.add_plane(n, w));
        at_q.add(&at_p.transported(q - p));
        for x in [q, p, DVec3::ZERO, DVec3::new(10.0, -3.0, 0.1)] {
            let expected = direct(&planes, x);
            assert!((at_q.at(x - q) - expected).abs() < 1e-9 * expected.max(1.0), "{x}");
        }
        assert!((at_q.weight - 6.5).abs() < 1e-12);
        assert!((at_q.distance() - (direct(&planes, q) / 6.5).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_new_quadric_costs_nothing_where_it_is_even_far_from_the_origin() {
        let mut quadric = Quadric::default();
        quadric.add_plane(DVec3::new(1.0, 2.0, 3.0).normalize(), 1e6);
        assert_eq!(quadric.at(DVec3::ZERO), 0.0);
    }
}
