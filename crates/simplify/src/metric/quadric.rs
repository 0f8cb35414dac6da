//! The quadric metric: distance to the planes of the *current* surface, with a small accumulated
//! term.
//!
//! The main term refits the quadric of a group to the faces around it each time it is asked
//! (memoryless simplification, Lindstrom and Turk 1998), which on scans is clearly better than
//! accumulated quadrics (Garland and Heckbert 1997). On thin shapes it forgets what has been lost
//! already; a share of the accumulated quadrics repairs that, and they also give the reported
//! error.

use super::Metric;
use crate::fan::{Facet, Lanes};
use crate::neighborhood::{FeaturePlane, Neighborhood};
use crate::quadric::{Quadric, Symmetric, add_outer};
use crate::wedges::Wedges;
use crate::working::{OPEN, Working};

/// Orders collapses of equal cost, for example in planes, by length.
const TIE_WEIGHT: f64 = 1e-9;
/// The share of the accumulated quadrics.
const MEMORY: f64 = 0.08;
const NONE: u32 = u32::MAX;

pub(crate) struct QuadricMetric {
    /// Planes of the input's faces, accumulated.
    surface: Vec<Quadric>,
    /// Planes along the input's borders, for the few groups that have any.
    border: Vec<Quadric>,
    border_of: Vec<u32>,
}

/// A group's refitted quadric, with its share of the accumulated one.
pub(crate) struct Local {
    a: Symmetric,
    b: glam::DVec3,
    c: f64,
}

impl Local {
    /// Adds the share of an accumulated quadric.
    fn remember(&mut self, old: &Quadric) {
        for (x, o) in self.a.iter_mut().zip(old.a) {
            *x += MEMORY * o;
        }
        self.b += MEMORY * old.b;
        self.c += MEMORY * old.c;
    }
}

impl QuadricMetric {
    pub(crate) fn new(mesh: &Working, wedges: &Wedges) -> Self {
        let mut surface = vec![Quadric::default(); mesh.places.len()];
        for f in &mesh.faces {
            for &g in &f.groups {
                surface[g as usize].add_plane(f.normal.as_dvec3(), f64::from(f.area));
            }
        }
        let mut metric =
            Self { surface, border: Vec::new(), border_of: vec![NONE; mesh.places.len()] };
        let mut around = Neighborhood::default();
        for g in (0..mesh.places.len() as u32).filter(|&g| mesh.has(g, OPEN)) {
            around.look(mesh, wedges, g);
            let mut quadric = Quadric::default();
            for plane in around.planes.iter().filter(|_| around.borders > 0) {
                quadric.add_plane(plane.normal, plane.weight);
            }
            if quadric.weight > 0.0 {
                metric.border_of[g as usize] = metric.border.len() as u32;
                metric.border.push(quadric);
            }
        }
        metric
    }
}

impl Metric for QuadricMetric {
    type Local = Local;
    type ViewScratch = ();

    fn local(&self, from: u32, facets: &[Facet], features: &[FeaturePlane]) -> Local {
        let mut a = [0.0; 6];
        let mut weight = 0.0;
        for f in facets {
            add_outer(&mut a, f.normal.as_dvec3(), f64::from(f.area));
            weight += f64::from(f.area);
        }
        for plane in features {
            add_outer(&mut a, plane.normal, plane.weight);
        }
        for i in [0, 3, 5] {
            a[i] += TIE_WEIGHT * weight;
        }
        let mut local = Local { a, b: glam::DVec3::ZERO, c: 0.0 };
        local.remember(&self.surface[from as usize]);
        if self.border_of[from as usize] != NONE {
            local.remember(&self.border[self.border_of[from as usize] as usize]);
        }
        local
    }

    #[inline]
    fn costs(&self, local: &Local, lanes: &Lanes, costs: &mut [f64]) {
        let Local { a: [xx, xy, xz, yy, yz, zz], b, c } = *local;
        let (xy, xz, yz, bx, by, bz) =
            (2.0 * xy, 2.0 * xz, 2.0 * yz, 2.0 * b.x, 2.0 * b.y, 2.0 * b.z);
        let lanes = lanes.x.iter().zip(&lanes.y).zip(&lanes.z).zip(&lanes.arrival);
        for (cost, (((&x, &y), &z), &arrival)) in costs.iter_mut().zip(lanes) {
            let moved = x * (xx * x + xy * y + xz * z + bx)
                + y * (yy * y + yz * z + by)
                + z * (zz * z + bz)
                + c;
            *cost = moved.max(0.0) + arrival;
        }
    }

    fn collapsed(&mut self, mesh: &mut Working, _wedges: &Wedges, from: u32, to: u32) {
        let delta = mesh.position(to) - mesh.position(from);
        let moved = self.surface[from as usize].transported(delta);
        self.surface[to as usize].add(&moved);
        mesh.places[to as usize].arrival = (MEMORY * self.surface[to as usize].c) as f32;
        let (source, target) = (self.border_of[from as usize], self.border_of[to as usize]);
        if source != NONE {
            let moved = self.border[source as usize].transported(delta);
            if target == NONE {
                self.border[source as usize] = moved;
                self.border_of[to as usize] = source;
            } else {
                self.border[target as usize].add(&moved);
            }
        }
    }

    fn error(&self, group: u32) -> f64 {
        let border = self.border_of[group as usize];
        let border = if border == NONE { 0.0 } else { self.border[border as usize].distance() };
        self.surface[group as usize].distance().max(border)
    }
}
