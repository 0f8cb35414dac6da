//! The input of commands that need levels: a `.lodc` file that is read, or a mesh file that is
//! imported and simplified in memory.

use crate::commands::build::{importance, object_options};
use crate::exit::Outcome;
use crate::importance::ImportanceArgs;
use crate::kinds::{MetricArgs, PosesArgs};
use crate::limits::ImportArgs;
use crate::parts::PartArgs;
use crate::progress::Progress;
use crate::stages::Stages;
use clap::Args;
use lodc::{
    Input, LodObject,
    build::{
        LevelDistance, MetricColours, Need, SceneColours, SceneContext, Size, Tick, choose_poses,
        measure_all, measure_levels, simplify_all,
    },
    read_input,
};
use lodc_formats::{Document, Limits, ObjectInfo, RequestedFiles, Scene, Source, appearance};
use lodc_mesh::Lod;
use lodc_select::Target;
use lodc_simplify::{MetricKind, Options};
use std::path::Path;
use std::sync::Arc;

/// An asset whose levels can be taken out.
pub(crate) struct AssetWithLevels {
    pub(crate) source: Source,
    pub(crate) objects: Vec<LodObject>,
    pub(crate) document: Document,
    /// Whether the geometry of the input was compressed.
    pub(crate) compressed: bool,
    /// Every file that was looked for.
    pub(crate) files: RequestedFiles,
    /// Messages about what was repaired, dropped or left out while reading.
    pub(crate) warnings: Vec<String>,
    /// The levels whose errors were asked for, and those whose errors its sequences state.
    asked: Errors,
    errors: Errors,
    /// The colours of the scene, if the metric used them.
    colours: Option<Arc<SceneColours>>,
}

/// The levels whose errors are measured: measuring all takes longer than simplifying does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Errors {
    /// Every level.
    Curve,
    /// Only the levels that are written, once they are chosen: by [`AssetWithLevels::distances`].
    OfResult,
}

impl Errors {
    /// The errors that are needed to choose levels by these targets.
    pub(crate) fn to_choose(targets: impl IntoIterator<Item = Target>) -> Self {
        let needs_no_error =
            |t| matches!(t, Target::Lod(_) | Target::Ratio(_) | Target::Triangles(_));
        if targets.into_iter().all(needs_no_error) { Self::OfResult } else { Self::Curve }
    }
}

impl AssetWithLevels {
    /// The distances of `levels`, fine to coarse, each with a LOD for every object; by level and
    /// object. Those that the sequences state, or measured if they state none.
    ///
    /// # Errors
    /// If the document is damaged.
    pub(crate) fn distances(
        &self,
        levels: &[&[Lod]],
        limits: &Limits,
        tick: &Tick<'_>,
    ) -> Outcome<Vec<Vec<LevelDistance>>> {
        if self.errors == Errors::OfResult {
            return Ok(measure_levels(&self.objects, levels, &self.document, limits, tick)?);
        }
        let stated = |(object, &lod): (&LodObject, &Lod)| LevelDistance::stated(object, lod);
        let of_level =
            |lods: &&[Lod]| self.objects.iter().zip(*lods).map(stated).collect::<Vec<_>>();
        Ok(levels.iter().map(of_level).collect())
    }

    /// Returns whether it was a mesh, simplified by the quadric and with errors of results only.
    pub(crate) fn is_by_quadric(&self, simplify_args: &SimplifyArgs) -> bool {
        self.asked == Errors::OfResult && simplify_args.metric.metric == MetricKind::Quadric
    }

    /// The colours of the scene, read now unless the metric used them. Images that cannot be read
    /// are left out, with a line among the warnings of the appearance.
    ///
    /// # Errors
    /// If the document is damaged.
    pub(crate) fn colours(&self, input: &Path, import: &ImportArgs) -> Outcome<Arc<SceneColours>> {
        if let Some(colours) = &self.colours {
            return Ok(Arc::clone(colours));
        }
        let infos: Vec<&ObjectInfo> = self.objects.iter().map(|o| &o.info).collect();
        read_colours(input, import, &self.document, &infos)
    }
}

/// Reads the colours of a scene.
///
/// # Errors
/// If the document is damaged.
pub(crate) fn read_colours(
    input: &Path,
    import: &ImportArgs,
    document: &Document,
    infos: &[&ObjectInfo],
) -> Outcome<Arc<SceneColours>> {
    let mut assets = import.assets(input, None);
    let appearance = appearance(document, infos, &mut assets);
    Ok(Arc::new(SceneColours::new(
        appearance.map_err(|e| e.in_file(&input.display().to_string()))?,
    )))
}

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
) -> Outcome<AssetWithLevels> {
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
) -> Outcome<AssetWithLevels> {
    let read = stages.run("read", || read_input(input, &import.options()))?;
    if matches!(read, Input::Levels(_)) {
        let name = input.display().to_string();
        simplify_args.importance.refuse_for_sequence(&name)?;
        simplify_args.parts.all().refuse_sequence_options(&name)?;
    }
    match read {
        Input::Levels(file) => Ok(AssetWithLevels {
            source: file.source,
            objects: file.objects,
            document: file.document,
            compressed: false,
            files: RequestedFiles::only(input),
            warnings: file.left_out,
            asked: Errors::Curve,
            errors: Errors::Curve,
            colours: None,
        }),
        Input::Scene(scene) => {
            simplified_showing(progress, (input, import), simplify_args, errors, scene, stages)
        }
    }
}

/// Simplifies the objects of a scene and measures every level.
///
/// # Errors
/// If that would take more memory than there is, or a lock names nothing.
pub(crate) fn simplified(
    input: &Path,
    import: &ImportArgs,
    simplify_args: &SimplifyArgs,
    scene: Scene,
    stages: &mut Stages,
) -> Outcome<AssetWithLevels> {
    let progress = Progress::new(&input.display().to_string());
    simplified_showing(&progress, (input, import), simplify_args, Errors::Curve, scene, stages)
}

fn simplified_showing(
    progress: &Progress,
    (input, import): (&Path, &ImportArgs),
    simplify_args: &SimplifyArgs,
    asked: Errors,
    scene: Scene,
    stages: &mut Stages,
) -> Outcome<AssetWithLevels> {
    // Several objects share out triangles by errors.
    let errors = if scene.objects.len() > 1 { Errors::Curve } else { asked };
    let size = Size::of_objects(&scene.objects);
    let name = input.display().to_string();
    let limits = import.options().limits;
    let weights = simplify_args.importance.weights();
    let options = Options {
        metric: simplify_args.metric.metric,
        lock_border: simplify_args.importance.lock_border,
        weights,
        ..Options::DEFAULT
    };
    let options = object_options(&scene, options, simplify_args.parts.all());
    let needs = [size.simplify(options.iter().map(|o| o.metric)), size.errors()];
    import.limits().check_memory(&name, size, &needs)?;
    let colours = MetricColours::read(input, &import.options(), &scene, &options)?;
    let importance =
        importance(&scene, &options, &simplify_args.importance, simplify_args.parts.all())?;
    let Scene { source, document, objects, mut warnings, mut files, compressed, .. } = scene;
    let poses = simplify_args.poses.max_poses();
    let context = SceneContext {
        colours: colours.scene_colours(),
        importance: &importance,
        document: &document,
        poses,
        limits,
    };
    let watch = stages.watched(progress);
    let mut simplified = simplify_all(objects, &options, context, &watch)?;
    warnings.extend(colours.warnings);
    files.extend(&colours.files);
    match errors {
        Errors::OfResult => drop(choose_poses(&mut simplified, &document, &limits, poses)?),
        Errors::Curve => {
            simplified = measure_all(simplified, &document, &limits, poses, &watch)?;
        }
    }
    drop(watch);
    warnings.extend(stages.take_notes());
    let object = |(info, simplified)| LodObject { info, simplified, models: Vec::new() };
    let objects = simplified.into_iter().map(object).collect();
    let colours = colours.colours;
    Ok(AssetWithLevels {
        source,
        objects,
        document,
        compressed,
        files,
        warnings,
        asked,
        errors,
        colours,
    })
}
