//! The closed list of strip generators ([`StripKind`]), strips together with the generator that
//! made them ([`Strips`]), and the strips that several models of one mesh share ([`StripPool`]).

use crate::cache::cache_reporting;
use crate::meter::Report;
use crate::stripe::stripe_reporting;
use crate::{CacheOptions, Effort, StripSet, strip_triangles};
use lodc_mesh::{Lod, Mesh, OrientedTriangle, Simplified, is_degenerate};
use rayon::prelude::*;
use std::ops::Deref;
use std::sync::Arc;

/// A strip generator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StripKind {
    /// Few long strips.
    Stripe,
    /// Short strips that reuse a vertex cache.
    Cache,
}

impl StripKind {
    /// All kinds, each at the number by which stored arrays name it.
    pub const ALL: [Self; 2] = [Self::Stripe, Self::Cache];

    /// The generator of the longest strips: for strips by themselves, baselines and pictures.
    pub const LONGEST: Self = Self::Stripe;

    /// The generator of strips with the fewest cache misses: for streams.
    pub const FEWEST_MISSES: Self = Self::Cache;

    /// The name in options and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stripe => "stripe",
            Self::Cache => "cache",
        }
    }

    /// One line of help.
    #[must_use]
    pub const fn help(self) -> &'static str {
        match self {
            Self::Stripe => "Few long strips",
            Self::Cache => "Short strips that reuse a vertex cache",
        }
    }

    /// Makes strips that draw exactly the mesh.
    #[must_use]
    pub fn generate(self, mesh: &Mesh, options: &CacheOptions) -> StripSet {
        self.generate_reporting(mesh, options, &|_| {})
    }

    fn generate_reporting(
        self,
        mesh: &Mesh,
        options: &CacheOptions,
        report: Report<'_>,
    ) -> StripSet {
        match self {
            Self::Stripe => stripe_reporting(mesh, options.effort, report),
            Self::Cache => cache_reporting(mesh, options, report),
        }
    }
}

/// Strips and what made them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Strips {
    /// The generator.
    pub kind: StripKind,
    /// The strips, which draw exactly a mesh in collapse order.
    pub set: StripSet,
}

impl Strips {
    /// Makes strips of a mesh in collapse order. Work runs on rayon's current thread pool; the
    /// result does not depend on it.
    #[must_use]
    pub fn generate(simplified: &Simplified, kind: StripKind, effort: Effort) -> Self {
        Self::generate_reporting(simplified, kind, effort, &|_| {})
    }

    fn generate_reporting(
        simplified: &Simplified,
        kind: StripKind,
        effort: Effort,
        report: Report<'_>,
    ) -> Self {
        let options = CacheOptions { effort, ..CacheOptions::default() };
        Self { kind, set: kind.generate_reporting(simplified.mesh(), &options, report) }
    }
}

impl Strips {
    /// Remains of the strips at a LOD: their triangles with every vertex resolved, and the strip of
    /// each. `simplified` is what they were made of.
    #[must_use]
    pub fn remains(&self, simplified: &Simplified, lod: Lod) -> (Vec<OrientedTriangle>, Vec<u32>) {
        let map = simplified.collapses().resolve_all(lod);
        let positions = simplified.mesh().position_ids();
        let at = |v: u32| positions.of_vertex[map[v as usize] as usize];
        let (mut triangles, mut strips) = (Vec::new(), Vec::new());
        for ((number, strip), submesh) in (0..).zip(self.iter()).zip(self.submeshes()) {
            for corners in strip_triangles(strip) {
                if !is_degenerate(corners.map(at)) {
                    let shown = corners.map(|v| map[v as usize]);
                    triangles.push(OrientedTriangle::new(submesh, shown));
                    strips.push(number);
                }
            }
        }
        (triangles, strips)
    }

    /// The strip that draws each triangle of the mesh, which must be the one that the strips draw;
    /// of equal triangles the lowest strip.
    #[must_use]
    pub fn of_triangles(&self, mesh: &Mesh) -> Vec<u32> {
        let sorted = |mut corners: [u32; 3]| {
            corners.sort_unstable();
            corners
        };
        let mut strip_by_corners: Vec<([u32; 3], u32)> = Vec::new();
        for (number, strip) in (0..).zip(self.iter()) {
            strip_by_corners.extend(strip.windows(3).map(|w| (sorted([w[0], w[1], w[2]]), number)));
        }
        strip_by_corners.sort_unstable();
        let of = |t: &[u32; 3]| {
            let index = strip_by_corners.partition_point(|(corners, _)| *corners < sorted(*t));
            strip_by_corners.get(index).map_or(0, |&(_, number)| number)
        };
        mesh.triangles().iter().map(of).collect()
    }
}

impl Deref for Strips {
    type Target = StripSet;

    fn deref(&self) -> &StripSet {
        &self.set
    }
}

/// The making of strips for models that need some.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StripOptions {
    /// The generator; each model has a default of its own.
    pub kind: Option<StripKind>,
    /// The time that it may take.
    pub effort: Effort,
}

/// The strips of one mesh, made when first asked for and shared by all models that are made of
/// them.
#[derive(Clone, Debug)]
pub struct StripPool<'a> {
    simplified: &'a Arc<Simplified>,
    options: StripOptions,
    pool: Vec<Arc<Strips>>,
}

impl<'a> StripPool<'a> {
    /// Starts without strips.
    #[must_use]
    pub fn new(simplified: &'a Arc<Simplified>, options: StripOptions) -> Self {
        Self { simplified, options, pool: Vec::new() }
    }

    /// The mesh and the sequence that models are made of.
    #[must_use]
    pub fn simplified(&self) -> &'a Arc<Simplified> {
        self.simplified
    }

    /// Returns strips by the generator of the options, or else by `default`.
    pub fn get(&mut self, default: StripKind) -> Arc<Strips> {
        let kind = self.options.kind.unwrap_or(default);
        self.make(&[kind], &|_| {});
        let strips = self.pool.iter().find(|strips| strips.kind == kind);
        Arc::clone(strips.expect("`make` has added it if it was missing"))
    }

    /// Returns the generators that [`Self::get`] would run for these defaults.
    #[must_use]
    pub fn missing(&self, defaults: &[StripKind]) -> Vec<StripKind> {
        let wanted = defaults.iter().map(|&kind| self.options.kind.unwrap_or(kind));
        let mut kinds: Vec<StripKind> = wanted.collect();
        kinds.sort_unstable();
        kinds.dedup();
        kinds.retain(|&kind| self.pool.iter().all(|strips| strips.kind != kind));
        kinds
    }

    /// Makes the strips that [`Self::get`] will be asked for, all generators at once.
    pub fn make(&mut self, defaults: &[StripKind], report: Report<'_>) {
        let (simplified, effort) = (self.simplified, self.options.effort);
        let missing = self.missing(defaults).into_par_iter();
        let generate = |kind| Strips::generate_reporting(simplified, kind, effort, report);
        self.pool.par_extend(missing.with_max_len(1).map(generate).map(Arc::new));
    }
}
