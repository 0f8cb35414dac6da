//! The hybrid metric: a collapse costs what it adds to the error of the shaded surface, as far as
//! anyone sees it.
//!
//! The input's surface is sampled. A sample remembers its place, the normal it was shaded with, and
//! how much of it is seen (by the cameras of viewpoint metrics). Its error is the squared distance
//! between that normal and the one that the nearest of today's faces is shaded with there (corner
//! normals, averaged across edges below 60°), plus a share of its distance from that face, and more
//! if nothing is left in its place: nearly the squared difference of pixels in pictures with a
//! light at the camera. Faces that come to lie where the input has nothing count too. Hidden
//! samples count for nothing, so what is hidden goes first, in the order of the quadric.
//!
//! Related: image-driven simplification (Lindstrom and Turk 2000) and point samples that follow the
//! surface (Hoppe 1996); here no picture is drawn while collapsing, and a collapse is looked at in
//! microseconds.

mod patch;
mod samples;
#[cfg(test)]
mod tests;
mod visibility;

pub(crate) use patch::Patch;

use super::Reprice;
use crate::wedges::Wedges;
use crate::working::WorkingMesh;
use samples::Samples;

/// A place this far off, as a share of the mesh's size, counts like a normal that is off by one
/// (60°). Measured (docs/BENCHMARKS.md): 0.02 to 0.05 hardly differ.
const DISTANCE: f64 = 0.025;
/// An attribute that is this far off, in the scale of attributes, counts like a normal that is off
/// by one.
const ATTRIBUTE: f64 = 0.005;
/// No more candidates of a group than this are looked at, the geometrically cheapest ones.
const MOST: usize = 4;
/// Faces times candidates that are looked at, at most.
const PATIENCE: usize = 64;
/// What geometry and attributes count for where nothing is seen, as a share of what they count for
/// elsewhere.
const HIDDEN: f64 = 1e-6;
/// Costs below zero, for collapses that improve the shading, come before this, the others after.
const ZERO: f64 = 1e-16;

pub(crate) struct HybridMetric {
    samples: Samples,
    /// The error of each face's samples.
    energy: Vec<f64>,
    /// What a squared distance counts for beside a squared difference of normals.
    distance: f32,
    /// What the quadric counts for: it decides where nothing is seen, and in planes.
    tie: f64,
    /// What attributes count for beside the quadric.
    attributes: f64,
    /// While every rule holds.
    awake: bool,
    /// How far what is seen has come to be from the last star that moved, if that was looked at.
    moved: Option<f64>,
    /// For commits.
    patch: Patch,
}

impl HybridMetric {
    /// `size` is the mesh's diagonal.
    pub(crate) fn new(mesh: &WorkingMesh, size: f64) -> Self {
        let mut samples = Samples::new(mesh);
        visibility::weigh(mesh, samples.all_mut());
        let per = |length: f64| if size > 0.0 { (length * size).powi(-2) } else { 0.0 };
        Self {
            samples,
            energy: vec![0.0; mesh.faces.len()],
            distance: per(DISTANCE) as f32,
            tie: per(1.0),
            attributes: (1.0 / ATTRIBUTE).powi(2),
            awake: false,
            moved: None,
            patch: Patch::default(),
        }
    }
}

impl Reprice for HybridMetric {
    type ViewScratch = Patch;

    fn attribute_weight(&self) -> f64 {
        if self.awake { self.attributes } else { 1.0 }
    }

    fn collapsed(&mut self, mesh: &WorkingMesh, _wedges: &Wedges, from: u32, to: u32) {
        self.moved = None;
        if self.awake {
            let star = mesh.star(from);
            self.patch.gather(mesh, from, &self.samples, &self.energy);
            self.patch.move_to(mesh, star, from, to);
            for corner in star {
                self.samples.clear(corner.face());
            }
            self.moved =
                Some(self.patch.settle(&mut self.samples, self.distance, &mut self.energy));
        }
    }

    /// The root mean square distance of what is seen, while that is looked at. Levels of several
    /// objects are chosen by it: what nobody sees must not keep one object fine while others go.
    fn error(&self) -> Option<f64> {
        self.moved
    }

    fn is_active(&self) -> bool {
        self.awake
    }

    fn should_toggle(&self, _mesh: &WorkingMesh) -> bool {
        false
    }

    fn toggle(&mut self, _mesh: &WorkingMesh, legal: bool) {
        self.awake = legal;
    }

    fn reprice(
        &self,
        mesh: &WorkingMesh,
        _wedges: &Wedges,
        from: u32,
        candidates: &mut [(f64, u32)],
        patch: &mut Patch,
    ) {
        let star = mesh.star(from);
        patch.gather(mesh, from, &self.samples, &self.energy);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let looked_at = (PATIENCE / star.len().max(1)).clamp(1, MOST).min(candidates.len());
        let (near, far) = candidates.split_at_mut(looked_at);
        let tie = self.tie * (patch.seen + HIDDEN);
        let mut worst = 0.0;
        for (cost, to) in near {
            patch.move_to(mesh, star, from, *to);
            let added = patch.energy(&self.samples, self.distance) - patch.present + tie * *cost;
            *cost = if added >= 0.0 { ZERO + added } else { ZERO * ZERO / (ZERO - added) };
            worst = cost.max(worst);
        }
        for (cost, _) in far {
            *cost = worst + tie * *cost;
        }
    }
}
