//! The quadrics of all groups: distance to the planes of the *current* surface, with a small
//! accumulated term.
//!
//! The main term refits the quadric of a group to the faces around it each time it is priced
//! (memoryless simplification, Lindstrom and Turk 1998), which on scans is clearly better than
//! accumulated quadrics (Garland and Heckbert 1997). On thin shapes it forgets what has been lost
//! already; a share of the accumulated quadrics repairs that, and they also give the reported
//! error. Both are areas times squared distances, in working units to the fourth power (a working
//! unit is a power of two in mesh units, so that the mesh is one to two across).

use super::reevaluate::Reevaluate;
use crate::cut::{
    Facet, FeaturePlane, Quadric, Quadrics, Symmetric, Wedges, WorkingMesh, add_outer, times,
};
use glam::DVec3;
use lodc_mesh::NONE;

/// Weight of the squared length of a collapse times the area around it. It orders collapses of
/// equal cost, as in planes, by length. Chosen by hand, far below what a surface that is not flat
/// costs.
pub(crate) const TIE_WEIGHT: f64 = 1e-9;
/// The share of the accumulated quadrics. Of 5 to 100 %, 8 % is best on six models together.
/// Without any, horns and ears are lost; accumulated quadrics alone have 10 to 35 % more error on
/// scans.
pub(crate) const MEMORY: f64 = 0.08;

/// A group's refitted quadric, with its share of the accumulated one: δᵀaδ + 2b·δ + c, δ from the
/// group's position.
pub(crate) struct Refitted {
    a: Symmetric,
    b: DVec3,
    c: f64,
}

impl Refitted {
    /// Adds the share of an accumulated quadric.
    fn remember(&mut self, old: &Quadric) {
        for (x, o) in self.a.iter_mut().zip(old.a) {
            *x += MEMORY * o;
        }
        self.b += MEMORY * old.b;
        self.c += MEMORY * old.c;
    }

    /// The cost of moving the group by `delta`, to which a collapse adds that of its target
    /// (`target_cost`); not negative.
    #[inline]
    pub(crate) fn cost(&self, delta: DVec3) -> f64 {
        let moved = delta.dot(times(&self.a, delta)) + 2.0 * self.b.dot(delta) + self.c;
        moved.max(0.0)
    }
}

impl Quadrics {
    /// Fits a group's quadric to the faces of its star and the planes of features through it.
    pub(crate) fn refit(&self, from: u32, facets: &[Facet], features: &[FeaturePlane]) -> Refitted {
        let mut a = [0.0; 6];
        let mut area = 0.0;
        for f in facets {
            add_outer(&mut a, f.normal.as_dvec3(), f64::from(f.area));
            area += f64::from(f.area);
        }
        self.refit_features(from, a, area, features)
    }

    /// Fits the quadric of a group in a shape in motion, where `old` is the accumulated one.
    pub(crate) fn refit_in_motion(
        old: &Quadric,
        facets: &[Facet],
        features: &[FeaturePlane],
    ) -> Refitted {
        let mut a = [0.0; 6];
        for f in facets {
            add_outer(&mut a, f.normal.as_dvec3(), f64::from(f.area));
        }
        for plane in features {
            add_outer(&mut a, plane.normal, plane.weight);
        }
        let mut refitted = Refitted { a, b: DVec3::ZERO, c: 0.0 };
        refitted.remember(old);
        refitted
    }

    /// Completes the quadric of a group by the planes of features through it. `a` is the sum over
    /// the faces of its star, or zero if they are priced apart; `area` is their area.
    pub(crate) fn refit_features(
        &self,
        from: u32,
        mut a: Symmetric,
        area: f64,
        features: &[FeaturePlane],
    ) -> Refitted {
        for plane in features {
            add_outer(&mut a, plane.normal, plane.weight);
        }
        for i in [0, 3, 5] {
            a[i] += TIE_WEIGHT * area;
        }
        let mut refitted = Refitted { a, b: DVec3::ZERO, c: 0.0 };
        refitted.remember(&self.surface[from as usize]);
        if let Some(border) = self.border(from) {
            refitted.remember(border);
        }
        refitted
    }

    /// Adds the quadrics of `from` to those of `to`, moved there, and updates the cost of moving
    /// onto `to`; in motion that is `moving_cost`, if it is greater.
    pub(crate) fn merge(&mut self, mesh: &mut WorkingMesh, from: u32, to: u32, moving_cost: f64) {
        let delta = mesh.position(to) - mesh.position(from);
        let moved = self.surface[from as usize].transported(delta);
        self.surface[to as usize].add(&moved);
        mesh.group_positions[to as usize].target_cost =
            (MEMORY * self.surface[to as usize].c.max(moving_cost)) as f32;
        let Some(border) = self.border(from) else { return };
        let moved = border.transported(delta);
        let (source, target) = (self.border_of[from as usize], self.border_of[to as usize]);
        if target == NONE {
            self.border[source as usize] = moved;
            self.border_of[to as usize] = source;
        } else {
            self.border[target as usize].add(&moved);
        }
    }

    /// Root mean square distance of `group` from the planes of the faces that have moved onto it,
    /// in working units.
    pub(crate) fn error(&self, group: u32) -> f64 {
        let border = self.border(group).map_or(0.0, Quadric::distance);
        self.surface[group as usize].distance().max(border)
    }
}

/// The quadric's costs as they are.
pub(crate) struct QuadricOnly;

impl Reevaluate for QuadricOnly {
    const REPRICES: bool = false;
    type ViewScratch = ();

    fn is_active(&self) -> bool {
        false
    }
    fn activity_changes(&self, _mesh: &WorkingMesh) -> bool {
        false
    }
    fn update_activity(&mut self, _mesh: &WorkingMesh, _legal: bool) {}
    fn reevaluate(
        &self,
        _: &WorkingMesh,
        _: &Wedges,
        _: u32,
        _: &mut [(f64, u32)],
        _: bool,
        (): &mut (),
    ) {
    }
    fn collapsed(&mut self, _: &WorkingMesh, _: &Wedges, _: u32, _: u32) {}
}
