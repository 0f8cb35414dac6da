//! Half-edge simplification over wedge groups, driven by a metric, down to a single vertex.
//!
//! A *wedge group* (the vertices at one position whose triangles hang together) moves onto a
//! neighbouring group as a whole, so no crack can open. Every vertex of the group gets a target
//! there: along the chosen edge (*true*), along the edges beside it in other wedges and submeshes
//! (*twin*), or a new vertex (*fake*) where there is none. (Thesis 3.2.1 and 4.2.1; rules of
//! legality and metrics: see [`MetricKind`] and `legality`.)

mod attributes;
mod build;
mod commit;
mod engine;
mod fan;
mod gradients;
mod heap;
mod legality;
mod log;
mod metric;
mod neighborhood;
mod output;
mod plan;
mod pool;
mod quadric;
mod wedges;
mod working;

use attributes::Attributes;
use build::Built;
use engine::Engine;
use legality::Stage;
use lodc_mesh::{CollapseSequence, Mesh, SequenceParts, Simplified};
use log::Log;
use metric::{HybridMetric, Metric, QuadricMetric, Score, VisualMetric};

/// What drives the collapses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum MetricKind {
    /// Distance to planes, refitted to the current surface, with a small accumulated term.
    #[default]
    Quadric,
    /// Viewpoint entropy over 20 pictures (thesis 3.2.1): what is hidden goes first, then what
    /// covers few pixels.
    Viewpoint,
    /// Kullback–Leibler divergence between areas seen and areas in space: flat regions go first,
    /// however they are cut up.
    Divergence,
    /// Error of the shaded surface, as far as it is seen: what a viewer would notice least goes
    /// first.
    Hybrid,
}

impl MetricKind {
    /// All metrics, in the order in which help lists them.
    pub const ALL: [Self; 4] = [Self::Quadric, Self::Viewpoint, Self::Divergence, Self::Hybrid];

    /// The name in options.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Quadric => "quadric",
            Self::Viewpoint => "viewpoint",
            Self::Divergence => "kl",
            Self::Hybrid => "hybrid",
        }
    }

    /// One line of help.
    #[must_use]
    pub const fn help(self) -> &'static str {
        match self {
            Self::Quadric => "Distance to the surface: the quickest, and the closest in space",
            Self::Viewpoint => "Viewpoint entropy over 20 pictures: hidden parts go first",
            Self::Divergence => {
                "Kullback-Leibler divergence between visible and actual areas over 20 pictures"
            }
            Self::Hybrid => "Error of the shaded surface where it is seen: looks best",
        }
    }
}

/// What a simplification respects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// What drives the collapses.
    pub metric: MetricKind,
    /// No topology change before the terminal phase.
    pub preserve_topology: bool,
    /// Border vertices stay until the terminal phase.
    pub lock_border: bool,
    /// Whether attributes take part in the cost.
    pub attributes: bool,
    /// Pixels across the pictures that viewpoint metrics look at, 8 to 1024. Time grows with its
    /// square.
    pub picture: u32,
}

impl Options {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        metric: MetricKind::Quadric,
        preserve_topology: false,
        lock_border: false,
        attributes: true,
        picture: 256,
    };
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Simplifies a mesh down to one vertex. `progress` is told (steps done, groups in all) now and
/// then. The result does not depend on the number of threads of the rayon pool it runs in.
#[must_use]
pub fn simplify(
    mesh: &Mesh,
    options: &Options,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Simplified {
    if mesh.vertex_count() == 0 {
        let empty = CollapseSequence::try_from(SequenceParts::default())
            .expect("an empty sequence is valid");
        return Simplified::new(mesh.clone(), empty).expect("no vertices need no records");
    }
    let built = build::build(mesh);
    let attributes = if options.attributes {
        Attributes::new(mesh, &built.working, &built.wedges.attributes_of, built.size)
    } else {
        Attributes::none()
    };
    let (working, wedges) = (&built.working, &built.wedges);
    match options.metric {
        MetricKind::Quadric => {
            run(mesh, options, QuadricMetric::new(working, wedges), built, attributes, progress)
        }
        MetricKind::Hybrid => {
            let metric = HybridMetric::new(working, wedges, built.size);
            run(mesh, options, metric, built, attributes, progress)
        }
        MetricKind::Viewpoint => {
            let metric = VisualMetric::new(working, wedges, Score::Entropy, options.picture);
            run(mesh, options, metric, built, attributes, progress)
        }
        MetricKind::Divergence => {
            let metric = VisualMetric::new(working, wedges, Score::Divergence, options.picture);
            run(mesh, options, metric, built, attributes, progress)
        }
    }
}

fn run<M: Metric>(
    mesh: &Mesh,
    options: &Options,
    metric: M,
    built: Built,
    attributes: Attributes,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Simplified {
    let log = Log { death: vec![0; built.working.faces.len()], ..Log::default() };
    let mut engine = Engine {
        input: mesh,
        options: *options,
        mesh: built.working,
        wedges: built.wedges,
        attributes,
        size: built.size,
        metric,
        stage: Stage::Legal,
        restricted: 0,
        log,
    };
    engine.run(progress);
    // What only collapsing needs goes before the result comes: this is where memory peaks.
    let (wedges, log) = engine.into_result();
    output::output(mesh, &wedges, &built.wedge_of, log, 1.0 / built.scale)
}

#[cfg(test)]
mod tests;
