//! The hybrid metric: a collapse costs what it adds to the error of the shaded surface, as far as anyone sees it.
//!
//! The input's surface is sampled. A sample remembers its place, the normal it was shaded with, and how much of it is
//! seen (by the cameras of viewpoint metrics). Its error is the squared distance between that normal and the one that
//! the nearest of today's faces is shaded with there (corner normals, averaged across edges below 60°), plus a share
//! of its distance from that face: nearly the squared difference of pixels in pictures with a light at the camera. Hidden
//! samples count for nothing, so what is hidden goes first, in the order of the quadric.
//!
//! Related: image-driven simplification (Lindstrom and Turk 2000) and point samples that follow the surface (Hoppe
//! 1996); here no picture is drawn while collapsing, and a collapse is looked at in microseconds.

mod patch;
mod samples;
mod sight;

pub(crate) use patch::Patch;

use super::{Metric, QuadricMetric};
use crate::fan::{Facet, Lanes};
use crate::neighborhood::FeaturePlane;
use crate::wedges::Wedges;
use crate::working::Working;
use samples::Samples;

fn env(name: &str, default: f64) -> f64 {
    std::env::var(name).ok().and_then(|s| s.parse().ok()).unwrap_or(default)
}

pub(crate) struct HybridMetric {
    quadric: QuadricMetric,
    samples: Samples,
    /// What each face counts for.
    energy: Vec<f64>,
    weights: Weights,
    /// From the quadric's unit to that of shading.
    tie: f64,
    attributes: f64,
    awake: bool,
    most: usize,
    patch: Patch,
}

/// What distances count for beside normals.
struct Weights {
    squared: f32,
    plain: f32,
}

impl Weights {
    #[inline]
    fn distance(&self, squared: f32) -> f32 {
        self.squared * squared + self.plain * squared.sqrt()
    }
}

/// Costs below zero, for collapses that improve the shading, come before this, the others after.
const ZERO: f64 = 1e-16;

impl HybridMetric {
    /// `size` is the mesh's diagonal.
    pub(crate) fn new(mesh: &Working, wedges: &Wedges, size: f64) -> Self {
        let mut samples = Samples::new(mesh);
        sight::weigh(mesh, samples.all_mut());
        let inv = |name: &str, default: f64, power: i32| {
            let x = env(name, default);
            if x > 0.0 && size > 0.0 { (x * size).powi(-power) } else { 0.0 }
        };
        let tie = inv("LAMBDA", 1.0, 2);
        Self {
            quadric: QuadricMetric::new(mesh, wedges),
            samples,
            energy: vec![0.0; mesh.faces.len()],
            weights: Weights { squared: inv("DIST", 0.03, 2) as f32, plain: inv("LIN", 0.0, 1) as f32 },
            tie,
            attributes: inv("ATTR", 0.005, 2) / tie,
            awake: false,
            most: env("MOST", 4.0) as usize,
            patch: Patch::default(),
        }
    }
}

impl Metric for HybridMetric {
    const LOOKS: bool = true;
    type Local = <QuadricMetric as Metric>::Local;
    type Eye = Patch;

    fn local(&self, from: u32, facets: &[Facet], features: &[FeaturePlane]) -> Self::Local {
        self.quadric.local(from, facets, features)
    }

    fn costs(&self, local: &Self::Local, lanes: &Lanes, costs: &mut [f64]) {
        self.quadric.costs(local, lanes, costs);
    }

    fn attribute_weight(&self) -> f64 {
        if self.awake { self.attributes } else { 1.0 }
    }

    fn collapsed(&mut self, mesh: &mut Working, from: u32, to: u32) {
        if self.awake {
            let star = mesh.star(from);
            self.patch.gather(mesh, from, &self.samples, &self.energy);
            self.patch.move_to(mesh, star, from, to);
            for corner in star {
                self.samples.clear(corner.face());
            }
            self.patch.settle(&mut self.samples, &self.weights, &mut self.energy);
        }
        self.quadric.collapsed(mesh, from, to);
    }

    fn error(&self, group: u32) -> f64 {
        self.quadric.error(group)
    }

    fn is_awake(&self) -> bool {
        self.awake
    }

    fn change(&mut self, _mesh: &Working, legal: bool) {
        self.awake = legal;
    }

    fn look(&self, mesh: &Working, from: u32, candidates: &mut [(f64, u32)], patch: &mut Patch) {
        let star = mesh.star(from);
        patch.gather(mesh, from, &self.samples, &self.energy);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let looked_at = (64 / star.len().max(1)).clamp(1, self.most).min(candidates.len());
        let (near, far) = candidates.split_at_mut(looked_at);
        let mut worst = 0.0;
        for (cost, to) in near {
            patch.move_to(mesh, star, from, *to);
            let added = patch.energy(&self.samples, &self.weights) - patch.present + self.tie * *cost;
            *cost = if added >= 0.0 { ZERO + added } else { ZERO * ZERO / (ZERO - added) };
            worst = cost.max(worst);
        }
        for (cost, _) in far {
            *cost = worst + self.tie * *cost;
        }
    }
}
