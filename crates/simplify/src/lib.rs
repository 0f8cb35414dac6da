//! Half-edge simplification over wedge groups, driven by a metric, down to a single vertex.
//!
//! A *wedge group* (the vertices at one position whose triangles hang together) moves onto a
//! neighbouring group as a whole, so no crack can open. Every vertex of the group gets a target
//! there: along the chosen edge (*true*), along the edges beside it in other wedges and submeshes
//! (*twin*), or a new vertex (*fake*) where there is none. (Thesis 3.2.1 and 4.2.1.)
//!
//! A mesh goes through seven stages, each a module that says what it does and why: `number`, `cut`,
//! `price` (by a [`metric`](MetricKind)), `choose`, `commit`, `rounds` and `output`. Where faces
//! lie on each other, one layer goes through them, and the others follow it (`shell`).
//!
//! ```
//! use lodc_simplify::{Options, simplify};
//!
//! let mesh = lodc_fixtures::icosphere(3);
//! let simplified = simplify(&mesh, &Options::DEFAULT, &|_, _| ());
//! let collapses = simplified.collapses();
//! let lod = collapses.lod_for_triangles(100);
//! assert_eq!(simplified.triangles_at(lod).len(), 100);
//! assert!(collapses.error_at(lod) < 0.1, "of a sphere whose radius is 1");
//! ```

mod choose;
mod commit;
mod cut;
mod importance;
mod locks;
mod metric;
mod number;
mod options;
mod output;
mod price;
mod recorded;
mod rounds;
mod seen;
mod shell;

use commit::{CollapseLog, Sources};
use cut::Region;
use lodc_mesh::{CollapseSequence, Mesh, PositionIds, Semantic, SequenceParts, Simplified};
use metric::{HybridMetric, QuadricOnly, Score, VisualMetric};
use number::Input;
use price::{Attributes, Context};
use rounds::{Progress, as_one, in_regions};
use shell::Shell;

pub use metric::{Checkerboard, SurfaceColours};
pub use options::{MetricKind, Options, Weights};
pub use recorded::RecordedCollapses;
pub use seen::{SeenShape, SeenShapes};

/// Simplifies a mesh down to one vertex. `progress` gets (steps done, steps at most) now and then.
/// The result does not depend on the number of threads of the rayon pool it runs in.
#[must_use]
pub fn simplify(
    mesh: &Mesh,
    options: &Options,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Simplified {
    simplify_guided(mesh, options, Guidance::default(), progress)
}

/// The same for a surface whose colours are known, which the hybrid metric looks at.
#[must_use]
pub fn simplify_coloured(
    mesh: &Mesh,
    options: &Options,
    colours: &dyn SurfaceColours,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Simplified {
    let guidance = Guidance { colours: Some(colours), ..Guidance::default() };
    simplify_guided(mesh, options, guidance, progress)
}

/// Knowledge of a surface besides its mesh, and of an earlier run. The default is none.
#[derive(Clone, Copy, Default)]
pub struct Guidance<'a> {
    /// Colours for [`MetricKind::Hybrid`]; none: a checkerboard by texture coordinates.
    pub colours: Option<&'a dyn SurfaceColours>,
    /// For each vertex: true if it stays where it is until the terminal phase. Empty: none does.
    pub locked: &'a [bool],
    /// For each vertex how much distances there count, from 0 (a tenth) to 1 (ten times); 0.5 is
    /// as usual. At one position the largest counts. Empty: as usual everywhere.
    pub importance: &'a [f32],
    /// For each submesh the importance of its attributes, in place of [`Options::weights`]. Empty:
    /// that of the options for all.
    pub weights: &'a [Weights],
    /// Shares of the triangles, the larger of each pair first, between which
    /// [`MetricKind::Hybrid`] chooses collapses; elsewhere the quadric does. None: it always does.
    pub hybrid_ranges: Option<&'a [[f32; 2]]>,
    /// The shapes in which the surface is seen. None: the one that it has as it was modelled.
    pub shapes: Option<&'a SeenShapes>,
    /// An earlier run of the same mesh by the same options that this one repeats first.
    pub prefix: Option<Prefix<'a>>,
}

/// The part of an earlier run that another one repeats.
#[derive(Clone, Copy, Debug)]
pub struct Prefix<'a> {
    /// The collapses of the earlier run.
    pub collapses: &'a RecordedCollapses,
    /// The share of the triangles down to which they are repeated.
    pub share: f32,
}

/// Simplifies a mesh about which more is known.
#[must_use]
pub fn simplify_guided(
    mesh: &Mesh,
    options: &Options,
    guidance: Guidance<'_>,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Simplified {
    simplify_recorded(mesh, options, guidance, progress).0
}

/// The same, with the collapses for another run to repeat. Only [`MetricKind::Hybrid`] records any.
#[must_use]
pub fn simplify_recorded(
    mesh: &Mesh,
    options: &Options,
    guidance: Guidance<'_>,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> (Simplified, RecordedCollapses) {
    let (simplified, recorded) =
        simplify_with(mesh, options, guidance, rounds::REGION_GROUPS, progress);
    let locked = locks::locked_positions(mesh, options, guidance.locked);
    (simplified.with_locked_positions(locked.into_iter()), recorded)
}

/// Simplifies in regions of about `region_groups` groups. One keeps the exact order of costs.
fn simplify_with(
    mesh: &Mesh,
    options: &Options,
    guidance: Guidance<'_>,
    region_groups: usize,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> (Simplified, RecordedCollapses) {
    if mesh.vertex_count() == 0 {
        let empty = CollapseSequence::try_from(SequenceParts::default())
            .expect("an empty sequence is valid");
        let empty = Simplified::new(mesh.clone(), empty).expect("no vertices need no records");
        return (empty, RecordedCollapses::default());
    }
    let positions = mesh.position_ids();
    let painted = importance::of_positions(guidance.importance, &positions);
    let guidance = Guidance { importance: &painted, ..guidance };
    let run = Run { mesh, options, guidance, region_groups, progress };
    let shell = Shell::of(mesh, &positions);
    if let Some(simplified) = shell.and_then(|shell| run.by_shell(&shell, &positions)) {
        return simplified;
    }
    let as_modelled = SeenShapes::default();
    let seen = guidance.shapes.unwrap_or(&as_modelled);
    let mut input = Input::with_positions(mesh, &positions, seen);
    drop(positions);
    input.lock(guidance.locked);
    input.weigh(&painted);
    run.set_counting(&mut input);
    let mut sources = Sources::new(&input);
    let Collapsed { mut log, legal, by_stamp } = run.collapse(&input, &mut sources);
    let recorded = std::mem::take(&mut log.recorded);
    (output::output(&input, &sources, log, legal, by_stamp), recorded)
}

/// The input of one simplification.
#[derive(Clone, Copy)]
struct Run<'a> {
    mesh: &'a Mesh,
    options: &'a Options,
    guidance: Guidance<'a>,
    region_groups: usize,
    progress: &'a (dyn Fn(u64, u64) + Sync),
}

/// The log of a mesh down to one vertex.
struct Collapsed {
    log: CollapseLog,
    /// Number of its steps before the terminal phase, which makes those that are not legal.
    legal: usize,
    /// True if its steps still have to be sorted by their stamps: those of several regions.
    by_stamp: bool,
}

impl<'a> Run<'a> {
    /// Simplifies one layer of a mesh whose faces lie on each other; the whole mesh follows. None
    /// if it cannot.
    fn by_shell(
        self,
        shell: &Shell,
        positions: &PositionIds,
    ) -> Option<(Simplified, RecordedCollapses)> {
        let (layer_collapses, recorded, legal) = {
            let seen = self.guidance.shapes.map(|seen| seen.gathered(&shell.vertices));
            let seen = seen.unwrap_or_default();
            let mut input = Input::with_positions(&shell.mesh, &shell.mesh.position_ids(), &seen);
            self.set_counting(&mut input);
            input.lock(&shell.locked(self.mesh, positions, self.guidance.locked));
            let painted = self.guidance.importance;
            let of_shell = shell.vertices.iter().filter_map(|&v| painted.get(v as usize).copied());
            input.weigh(&of_shell.collect::<Vec<_>>());
            input.planes = shell.planes(self.mesh, positions, &input);
            let mut sources = Sources::new(&input);
            let guidance = Guidance { shapes: Some(&seen), ..self.guidance };
            let run = Run { mesh: &shell.mesh, guidance, ..self };
            let Collapsed { mut log, legal, by_stamp } = run.collapse(&input, &mut sources);
            let recorded = std::mem::take(&mut log.recorded);
            (
                shell::layer_collapses(&input, &shell.vertices, &log, legal, by_stamp),
                recorded,
                legal,
            )
        };
        let as_modelled = SeenShapes::default();
        let mut input = Input::with_positions(self.mesh, positions, &as_modelled);
        self.set_counting(&mut input);
        let context = self.context(&input);
        let mut sources = Sources::new(&input);
        let (log, legal) = shell::follow(&context, &layer_collapses, legal, &mut sources)?;
        drop(context);
        Some((output::output(&input, &sources, log, legal, false), recorded))
    }

    /// Tells an input which attributes count: those with a weight.
    fn set_counting(&self, input: &mut Input<'_>) {
        input.set_counting(|submesh, attribute| {
            let weights = self.weights(submesh);
            self.options.attributes
                && match attribute.semantic {
                    Semantic::Normal => weights.normal > 0.0,
                    Semantic::TexCoord(_) => weights.uv > 0.0,
                    Semantic::Color(_) => weights.color > 0.0,
                    _ => true,
                }
        });
    }

    /// The weights of a submesh's attributes.
    fn weights(&self, submesh: u32) -> Weights {
        self.guidance.weights.get(submesh as usize).copied().unwrap_or(self.options.weights)
    }

    /// The data that all regions read.
    fn context<'i>(&self, input: &'i Input<'i>) -> Context<'i> {
        let Self { mesh, options, .. } = *self;
        let attributes = if options.attributes {
            let as_modelled = SeenShapes::default();
            let seen = self.guidance.shapes.unwrap_or(&as_modelled);
            let weights = |submesh: u32| {
                let weights = self.weights(submesh);
                Weights { skin: if seen.joints_move { 0.0 } else { weights.skin }, ..weights }
            };
            Attributes::new(mesh, seen, weights, input.scale, input.size)
        } else {
            Attributes::none()
        };
        Context { input, options: *options, attributes }
    }

    /// Collapses all groups. All buffers are freed on return, before the result is made of the log:
    /// memory is highest there.
    fn collapse(&self, input: &Input<'_>, sources: &mut Sources<'_>) -> Collapsed {
        let Self { mesh, options, guidance, region_groups, .. } = *self;
        let progress = Progress::new(self.progress, input.groups() as u64);
        let context = self.context(input);
        let in_rounds = options.metric == MetricKind::Quadric
            && input.groups() / rounds::MIN_REGIONS >= region_groups;
        let (log, legal) = match options.metric {
            MetricKind::Quadric if in_rounds => {
                in_regions(&context, region_groups, sources, &progress)
            }
            MetricKind::Quadric => as_one(&context, |_| QuadricOnly, sources, &progress),
            MetricKind::Hybrid => {
                let checkerboard = Checkerboard::new(mesh);
                let colours = guidance.colours.unwrap_or(&checkerboard);
                let colours = options.attributes.then_some(colours);
                let metric =
                    |r: &Region| HybridMetric::new(mesh, colours, r, input.size, options, guidance);
                as_one(&context, metric, sources, &progress)
            }
            MetricKind::Viewpoint => {
                let metric =
                    |r: &Region| VisualMetric::new(&r.mesh, Score::Entropy, options.picture);
                as_one(&context, metric, sources, &progress)
            }
            MetricKind::Divergence => {
                let metric =
                    |r: &Region| VisualMetric::new(&r.mesh, Score::Divergence, options.picture);
                as_one(&context, metric, sources, &progress)
            }
        };
        Collapsed { log, legal, by_stamp: in_rounds }
    }
}

#[cfg(test)]
mod motion_tests;
#[cfg(test)]
mod tests;
