//! The stages of one build: import, simplify, errors, strips, models, check, write.

use super::{BuildArgs, counts, importance};
use crate::exit::{Failure, Outcome, Status};
use crate::jobs::Parts;
use crate::kinds::StepOrder;
use crate::output::{self, Target};
use crate::progress::Progress;
use crate::stages::Stages;
use lodc::pipeline::{Need, Size};
use lodc::{Asset, LodFile, LodObject, Simplify, parting_borders, parting_line, write};
use lodc_formats::gltf::embed_images;
use lodc_formats::images::{TextureMode, Textures};
use lodc_formats::lodc::MadeFrom;
use lodc_formats::lods::{self, as_streamed};
use lodc_formats::{Document, OutputFile, RequestedFiles, Scene, import};
use lodc_lod::ModelKind;
use lodc_mesh::Lod;
use lodc_report::documents::InputReport;
use lodc_simplify::{MetricKind, Options};
use rayon::prelude::*;
use std::path::Path;

/// What a build made.
pub(super) struct BuildOutput {
    pub(super) file: LodFile,
    /// Bytes of the file.
    pub(super) bytes: usize,
    pub(super) files: RequestedFiles,
    /// The file, if it is still to be written.
    pub(super) unwritten: Option<OutputFile>,
}

/// One build.
#[derive(Clone, Copy)]
pub(super) struct OneBuild<'a> {
    pub(super) args: &'a BuildArgs,
    pub(super) input: &'a Path,
    pub(super) target: &'a Target,
    /// Whether it comes from a folder or a list: its file is written later, together with others.
    pub(super) is_listed: bool,
}

/// Makes one file, and writes it unless it is listed. `report` is filled in as far as the work
/// gets.
pub(super) fn make(
    one: OneBuild<'_>,
    stages: &mut Stages,
    progress: &Progress,
    report: &mut InputReport,
) -> Outcome<BuildOutput> {
    let OneBuild { args, input, target, is_listed } = one;
    progress.stage("import");
    let scene = stages.run("import", || import::import(input, &args.import.options()))?;
    report.warnings.clone_from(&scene.warnings);
    let size = Size::of_objects(&scene.objects);
    report.triangles = Some(size.triangles);

    let options = object_options(&scene, args.simplify_options(), args.parts.all());
    let kinds = args.models.kinds()?;
    check_memory(args, input, size, &options, &kinds)?;
    let import = args.import.options();
    let from = (input, &import);
    let importance = importance(from, &scene, &options, &args.importance, args.parts.all())?;
    let poses = args.poses.max_poses();
    let how = Simplify { options: &options, importance: &importance, poses };
    let watch = stages.watched(progress);
    let mut asset = Asset::sequences(input, scene, &import, &how, &watch)?;
    if args.sequence.sequence == StepOrder::Stream {
        order_as_streamed(&mut asset.objects)?;
    }
    report.warnings.clone_from(&asset.warnings);
    let (textures, images) = images(args, input, &asset.document)?;
    asset.files.extend(&images);
    if args.embed {
        let placed = textures.placed(TextureMode::Embed, input);
        if !embed_images(&mut asset.document, &placed)? && asset.document.has_textures() {
            report.warnings.push(NOT_EMBEDDED.to_owned());
        }
        report.warnings.extend(placed.warnings);
    } else {
        // A metric that looks at colours has read images, and warned of some.
        let told = report.warnings.clone();
        let missing = textures.warnings.into_iter();
        report.warnings.extend(missing.filter(|line| !told.contains(line)));
    }
    let asset = asset.measured(poses, &watch)?;

    let bug = |error: lodc::Error| {
        Failure::new(Status::Bug, format!("{}: {error}; nothing was written", input.display()))
    };
    report.models = kinds.iter().map(|kind| kind.name()).collect();
    fill_in_counts(report, &asset.objects);
    let asset = asset.with_models(&kinds, args.strips.options(), &watch).map_err(bug)?;
    drop(watch);
    report.warnings.extend(stages.take_notes());
    let coarsest: Vec<Lod> = asset.objects.iter().map(|o| o.simplified.coarsest()).collect();
    let parting = parting_borders(&asset.objects, &coarsest, &asset.document, &import.limits)?;
    report.warnings.extend(parting_line(&parting));

    progress.stage("write");
    // A stream does not hold what its file was made from, and `unpack` gives this file again.
    let made_from = (args.sequence.sequence == StepOrder::Metric)
        .then(|| MadeFrom::of(input, &asset.files, &args.options_text, &report.warnings))
        .flatten();
    let files = asset.files.clone();
    let file = asset.into_file(args.models.layout(), made_from);
    output::refuse_replacing(target.file(), &files)?;
    let (bytes, unwritten) = stages.run("write", || {
        let bytes = write(&file);
        let length = bytes.len();
        match target {
            Target::File(path) if is_listed => {
                Ok((length, Some(OutputFile { path: path.clone(), bytes })))
            }
            _ => output::write(target, bytes).map(|()| (length, None)),
        }
    })?;
    report.bytes = Some(bytes as u64);
    Ok(BuildOutput { file, bytes, files, unwritten })
}

/// Puts the steps of objects into the order of streams.
fn order_as_streamed(objects: &mut [LodObject]) -> Outcome<()> {
    let order = lods::StepOrder::batches(objects.len());
    objects.par_iter_mut().try_for_each(|object| {
        object.simplified = as_streamed(&object.simplified, order)?.into();
        Ok(())
    })
}

const NOT_EMBEDDED: &str = "images are not embedded: the materials of an OBJ or PLY name files";

/// The image files that a document names: a file is up to date only if these are unchanged, too.
fn images(
    args: &BuildArgs,
    input: &Path,
    document: &Document,
) -> Outcome<(Textures, RequestedFiles)> {
    let mut assets = args.import.assets(input, None);
    let textures = Textures::read(document, &mut assets);
    let textures = textures.map_err(|e| e.in_file(&input.display().to_string()))?;
    Ok((textures, assets.files().clone()))
}

/// What the stages of a build need.
pub(super) fn needs(
    size: Size,
    metrics: impl Iterator<Item = MetricKind>,
    kinds: &[ModelKind],
) -> [Need; 3] {
    [size.simplify(metrics), size.errors(), size.models(kinds)]
}

/// Checks that the work on a scene fits into memory.
fn check_memory(
    args: &BuildArgs,
    input: &Path,
    size: Size,
    options: &[Options],
    kinds: &[ModelKind],
) -> Outcome<()> {
    let needs = needs(size, options.iter().map(|o| o.metric), kinds);
    args.import.limits().check_memory(&input.display().to_string(), size, &needs)
}

/// The options of every object: those of the asset, with those of its parts in their place.
pub(crate) fn object_options(scene: &Scene, options: Options, parts: Parts<'_>) -> Vec<Options> {
    scene.objects.iter().map(|o| parts.object_options(&o.info.name, options)).collect()
}

/// Fills in the counts of every object, and their sums.
fn fill_in_counts(report: &mut InputReport, objects: &[LodObject]) {
    report.objects = objects.iter().map(|o| counts(&o.info, &o.simplified)).collect();
    let sum = |of: fn(&lodc_report::documents::ObjectCounts) -> u64| {
        Some(report.objects.iter().map(of).sum())
    };
    let sums = [
        sum(|o| o.vertices),
        sum(|o| o.referenced_vertices),
        sum(|o| o.triangles),
        sum(|o| o.submeshes),
        sum(|o| o.fakes),
        sum(|o| o.records),
        sum(|o| o.steps),
        sum(|o| u64::from(o.last_legal_lod)),
    ];
    [
        report.vertices,
        report.referenced_vertices,
        report.triangles,
        report.submeshes,
        report.fakes,
        report.records,
        report.steps,
        report.last_legal_lod,
    ] = sums;
}
