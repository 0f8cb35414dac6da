//! The input of commands that need levels: a `.lodc` file that is read, or a mesh file that is
//! imported and simplified in memory.

use crate::commands::building::{importance, object_options};
use crate::exit::Outcome;
use crate::importance::ImportanceArgs;
use crate::kinds::{MetricArgs, PosesArgs};
use crate::limits::ImportArgs;
use crate::parts::PartArgs;
use crate::progress::Progress;
use crate::stages::Stages;
use clap::Args;
use lodc::pipeline::{Need, Size};
use lodc::{Asset, Errors, Input, Simplify, read_input};
use lodc_formats::Scene;
use lodc_simplify::{MetricKind, Options};
use std::path::Path;

/// Options of simplifying a mesh in memory.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct SimplifyArgs {
    #[command(flatten)]
    metric: MetricArgs,
    #[command(flatten)]
    importance: ImportanceArgs,
    #[command(flatten)]
    pub(crate) parts: PartArgs,
    #[command(flatten)]
    poses: PosesArgs,
}

impl SimplifyArgs {
    /// What the stages need for a scene of this size.
    pub(crate) fn needs(&self, size: Size) -> [Need; 2] {
        [size.simplify(std::iter::once(self.metric.metric)), size.errors()]
    }

    /// The metric of objects that have none of their own.
    pub(crate) fn metric(&self) -> MetricKind {
        self.metric.metric
    }

    /// The most poses that errors are measured in.
    pub(crate) fn max_poses(&self) -> usize {
        self.poses.max_poses()
    }

    /// Simplification by a metric, with nothing weighted or locked.
    pub(crate) fn by(metric: MetricKind) -> Self {
        Self { metric: MetricArgs { metric }, ..Self::default() }
    }
}

/// Reads an input; a mesh is simplified.
///
/// # Errors
/// If the input cannot be read, simplifying it would take more memory than there is, or weights
/// and locks do not suit it.
pub(crate) fn read(
    input: &Path,
    import: &ImportArgs,
    simplify_args: &SimplifyArgs,
    stages: &mut Stages,
) -> Outcome<Asset> {
    let progress = Progress::new(&input.display().to_string());
    read_showing(&progress, input, import, simplify_args, Errors::Curve, stages)
}

/// Reads an input as [`read`] does, and shows the progress of simplifying on a bar of the caller's.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_showing(
    progress: &Progress,
    input: &Path,
    import: &ImportArgs,
    simplify_args: &SimplifyArgs,
    errors: Errors,
    stages: &mut Stages,
) -> Outcome<Asset> {
    let read = stages.run("read", || read_input(input, &import.options()))?;
    if matches!(read, Input::Lodc(_)) {
        let name = input.display().to_string();
        simplify_args.importance.refuse_for_sequence(&name)?;
        simplify_args.parts.all().refuse_sequence_options(&name)?;
    }
    match read {
        Input::Lodc(file) => Ok(Asset::of_file(file, input, import.options().limits)),
        Input::Scene(scene) => {
            let errors = Some(errors);
            simplified_showing(progress, (input, import), simplify_args, errors, scene, stages)
        }
    }
}

/// Simplifies the objects of a scene and measures the levels of `errors`, if any.
///
/// # Errors
/// If that would take more memory than there is, or a lock names nothing.
pub(crate) fn simplified(
    input: &Path,
    import: &ImportArgs,
    simplify_args: &SimplifyArgs,
    errors: Option<Errors>,
    scene: Scene,
    stages: &mut Stages,
) -> Outcome<Asset> {
    let progress = Progress::new(&input.display().to_string());
    simplified_showing(&progress, (input, import), simplify_args, errors, scene, stages)
}

fn simplified_showing(
    progress: &Progress,
    (input, import): (&Path, &ImportArgs),
    simplify_args: &SimplifyArgs,
    errors: Option<Errors>,
    scene: Scene,
    stages: &mut Stages,
) -> Outcome<Asset> {
    let size = Size::of_objects(&scene.objects);
    let parts = simplify_args.parts.all();
    let options = Options {
        metric: simplify_args.metric.metric,
        lock_border: simplify_args.importance.lock_border,
        weights: simplify_args.importance.weights(),
        ..Options::DEFAULT
    };
    let options = object_options(&scene, options, parts);
    let needs = [size.simplify(options.iter().map(|o| o.metric)), size.errors()];
    import.limits().check_memory(&input.display().to_string(), size, &needs)?;
    let import = import.options();
    let from = (input, &import);
    let importance = importance(from, &scene, &options, &simplify_args.importance, parts)?;
    let poses = simplify_args.poses.max_poses();
    let how = Simplify { options: &options, importance: &importance, poses };
    let watch = stages.watched(progress);
    let mut asset = match errors {
        Some(errors) => Asset::simplified(input, scene, &import, &how, errors, &watch),
        None => Asset::sequences(input, scene, &import, &how, &watch),
    }?;
    drop(watch);
    asset.warnings.extend(stages.take_notes());
    Ok(asset)
}
