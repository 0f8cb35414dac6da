//! Extracts one level of one input, and encodes it as a mesh file.

use super::ExtractArgs;
use crate::commands::asset;
use crate::commands::records::Wanted;
use crate::compression::EncodeOptions;
use crate::exit::{Failure, Outcome};
use crate::mesh_output::{self, FormatName};
use crate::output::{self, DependencyRule, Target};
use crate::progress::Progress;
use crate::rounding::{Asked, Room, distances};
use crate::stages::Stages;
use crate::views::CriterionName;
use lodc::{
    Asset, Errors, SceneLevels, WrittenLevel,
    level_mesh::{self, LevelMesh, MeshOptions, Order},
    parting_borders, parting_line,
    pipeline::{Growth, measured, refitted_meshes},
    scene_levels, single,
};
use lodc_formats::{ObjectInfo, scene_graph};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::Lod;
use lodc_report::documents::{ExtractReport, ExtractedObject};
use lodc_report::{ErrorsOver, MissingPart, PartInventory, SCHEMA_VERSION};
use lodc_scene::Arrangement;
use lodc_simplify::MetricKind;
use std::path::{Path, PathBuf};

/// What extracting gave.
pub(super) struct Extracted {
    pub(super) report: ExtractReport,
    pub(super) rules: Vec<DependencyRule>,
    /// A line for people where another way is better.
    pub(super) tip: Option<&'static str>,
}

/// Extracts the level of one input and writes it to `target` as `format`. What was written is
/// recorded if that is `wanted`.
///
/// # Errors
/// If the input cannot be read, has no such level or model, or the output cannot be written.
pub(super) fn extract(
    args: &ExtractArgs,
    input: &Path,
    target: &Target,
    wanted: Option<Wanted<'_>>,
    format: FormatName,
    progress: &Progress,
) -> Outcome<Extracted> {
    let mut stages = Stages::new(args.export.import.clock(input));
    let criterion = args.criterion()?;
    let (import, simplify) = (&args.export.import, &args.export.simplify);
    let errors = errors(args, criterion);
    let asset = asset::read_showing(progress, input, import, simplify, errors, &mut stages)?;
    let encoding = args.export.compress.wanted(format, asset.compressed)?;
    let order = args.order.map_or(encoding.order(), Into::into);
    let limits = args.export.import.limits().limits();
    let mut scene = scene_levels(&asset.objects, &asset.document, &limits)?;
    let asked = if criterion.is_some() { Vec::new() } else { asked(args) };
    let mut room = Room::new(&asset, format.export_format(), encoding.precision, &asked)?;
    let level = match criterion {
        Some(name) => view(args, name, order, input, &asset, &scene, &mut stages)?,
        None => {
            let to_choose = (&mut scene, &mut room, &asked[..]);
            uniform(args, order, errors, input, &asset, to_choose, &mut stages)?
        }
    };
    let textures = stages.run("textures", || {
        args.export.textures.placed(&asset.document, input, &args.export.import, target, format)
    });
    let (textures, images) = textures?;
    let encoded = |encoding: EncodeOptions| -> Outcome<_> {
        let mut options = encoding.options(textures.clone());
        let path = mesh_output::path(target, format);
        let level_of = asset.level_of(single(&level.lods).flatten());
        let made = level_of.files(&level.meshes, &path, format.export_format(), &mut options)?;
        let mut report = report(input, &asset, &level, &made, target);
        report.warnings.extend_from_slice(&textures.warnings);
        report.warnings.extend(made.left_out);
        report.warnings.extend(made.warnings);
        let before = distances(&level.meshes);
        report.warnings.extend(room.unmet(&scene, &asked, &before, &made.of_objects));
        Ok((report, made.files))
    };
    let (mut report, mut files) = stages.run("export", || encoded(encoding))?;
    if let Some(alternative) = encoding.alternative() {
        let (plain_report, plain_files) = stages.run("export", || encoded(alternative))?;
        if let Some(line) = EncodeOptions::prefers_plain(&files, &plain_files) {
            (report, files) = (plain_report, plain_files);
            report.warnings.push(line);
        }
    }
    let looks_matter = asset.document.has_textures() && report.kept_share <= FEW;
    let is_by_quadric =
        asset.simplified && errors == Errors::OfResult && simplify.metric() == MetricKind::Quadric;
    let tip = (is_by_quadric && looks_matter).then_some(TIP);
    let outputs: Vec<PathBuf> = files.iter().map(|file| file.path.clone()).collect();
    let mut read = asset.files;
    read.extend(&images);
    output::refuse_replacing(outputs.iter().map(PathBuf::as_path), &read)?;
    stages.run("write", || mesh_output::write(target, files))?;
    progress.clear();
    let rules = match target {
        Target::File(path) => vec![DependencyRule::new(path, &read)],
        Target::Stdout => vec![],
    };
    if let Some(wanted) = wanted {
        wanted.record(&outputs, &rules, (&read, &images), &report.warnings)?;
    }
    Ok(Extracted { report, rules, tip })
}

/// Share of the triangles up to which `hybrid` may be worth its time for textured meshes.
const FEW: f64 = 0.1;
const TIP: &str = "tip: with so few triangles textures may look better by --metric hybrid (by 5 % \
                   in the mean), which takes 5 to 20 times as long";

/// The errors that choosing a level takes.
fn errors(args: &ExtractArgs, criterion: Option<CriterionName>) -> Errors {
    match criterion {
        Some(CriterionName::Pixels) => Errors::Curve,
        _ => Errors::to_choose(args.selector.target().into_iter().chain(args.max_error)),
    }
}

/// The largest distances that are asked for.
fn asked(args: &ExtractArgs) -> Vec<Asked> {
    let per_object = args.selector.per_object();
    let max_error = |target| Asked { option: "--max-error", target, per_object };
    args.selector.largest_distance().into_iter().chain(args.max_error.map(max_error)).collect()
}

/// A level that was taken out.
struct ExtractedLevel {
    meshes: Vec<LevelMesh>,
    /// The LOD of each object; none in a view.
    lods: Vec<Option<Lod>>,
    model: &'static str,
    criterion: Option<CriterionName>,
    /// Parts that the level no longer shows; none in a view, where it is not looked for.
    gone: Option<Vec<MissingPart>>,
    warnings: Vec<String>,
}

/// One level of detail for each object, chosen anew until what is written leaves `room`.
fn uniform(
    args: &ExtractArgs,
    order: Order,
    errors: Errors,
    input: &Path,
    asset: &Asset,
    (scene, room, asked): (&mut SceneLevels<'_>, &mut Room<'_>, &[Asked]),
    stages: &mut Stages,
) -> Outcome<ExtractedLevel> {
    let shape = MeshOptions { model: model(args, input, asset)?, order };
    let limits = args.export.import.limits().limits();
    let wanted = args.selector.target().expect("there is a level or a criterion");
    let per_object = args.selector.per_object();
    let own = |object: &str| args.export.simplify.parts.all().extract_level(object);
    let (chosen, meshes) = loop {
        room.leave(scene);
        let chosen = stages
            .run("select", || scene.select_capped(wanted, own, args.max_error, per_object))?;
        let lods = &chosen.lods;
        let meshes = if args.refits() {
            stages.checked("extract", |tick| {
                let how = (order, Growth::from(errors));
                refitted_meshes(&asset.objects, &asset.document, lods, how, &limits, tick)
            })?
        } else {
            let distances =
                stages.checked("errors", |tick| asset.distances(&[lods], tick))?.swap_remove(0);
            let meshes = stages.run("extract", || level_mesh::meshes(&asset.objects, lods, shape));
            let mut meshes = meshes?;
            for (mesh, distance) in meshes.iter_mut().zip(distances) {
                (mesh.error, mesh.rms) = (distance.error, distance.rms);
            }
            meshes
        };
        if !room.make_more(scene, asked, &meshes)? {
            break (chosen, meshes);
        }
    };
    let lods = &chosen.lods;
    let parting = parting_borders(&asset.objects, lods, &asset.document, &limits)?;
    let inventory = PartInventory::new(&asset.objects, scene, &asset.document)?;
    let gone = stages.run("gone", || inventory.gone_at(lods, meshes.iter().map(|mesh| mesh.error)));
    Ok(ExtractedLevel {
        meshes,
        lods: chosen.lods.into_iter().map(Some).collect(),
        model: shape.model.map_or("reference", ModelKind::name),
        criterion: None,
        warnings: chosen
            .warnings
            .into_iter()
            .chain(parting_line(&parting))
            .chain(gone.iter().map(MissingPart::to_string))
            .collect(),
        gone: Some(gone),
    })
}

/// A level of detail for every part of the surface. Its error is measured.
fn view(
    args: &ExtractArgs,
    name: CriterionName,
    order: Order,
    input: &Path,
    asset: &Asset,
    levels: &SceneLevels<'_>,
    stages: &mut Stages,
) -> Outcome<ExtractedLevel> {
    args.view.check_models(input, &asset.objects)?;
    let limits = args.export.import.limits().limits();
    let infos: Vec<&ObjectInfo> = asset.objects.iter().map(|o| &o.info).collect();
    let graph = scene_graph(&asset.document, &infos, &limits)?;
    let pose = args.pose.of(input, &asset.document, &graph, &limits)?;
    let scene = Arrangement::new(&graph, &pose, infos.len());
    let views = stages
        .run("select", || args.view.of_scene(name, &args.selector, levels, &scene))
        .map_err(|f| Failure { message: format!("{}: {f}", input.display()), ..f })?;
    let shown =
        stages.run("extract", || views.show(views.max_triangles(args.selector.target())))?;
    let meshes = views.meshes(&shown)?.into_iter().map(|m| level_mesh::ordered(m, order));
    let meshes = meshes.collect();
    Ok(ExtractedLevel {
        meshes: stages
            .run("measure", || measured(&asset.objects, &asset.document, meshes, &limits))?,
        lods: vec![None; asset.objects.len()],
        model: ModelKind::Interactive.name(),
        criterion: Some(name),
        gone: None,
        warnings: shown.warnings,
    })
}

/// The model to replay, unless asked otherwise the first that is stored; the reference if none.
///
/// # Errors
/// If the objects do not have the model that was asked for.
fn model(args: &ExtractArgs, input: &Path, asset: &Asset) -> Outcome<Option<ModelKind>> {
    let stored =
        || asset.objects.first().into_iter().flat_map(|o| o.models.iter().map(AnyModel::kind));
    let Some(name) = args.model else { return Ok(stored().next()) };
    let Some(wanted) = name.kind() else { return Ok(None) };
    if asset.objects.is_empty() || stored().any(|kind| kind == wanted) {
        return Ok(Some(wanted));
    }
    let has: Vec<_> = stored().map(ModelKind::name).chain(["reference"]).collect();
    Err(Failure::usage(format!(
        "{}: has no model {} (it has: {})",
        input.display(),
        wanted.name(),
        has.join(", ")
    )))
}

/// The report on a level and on what its files state.
fn report(
    input: &Path,
    asset: &Asset,
    level: &ExtractedLevel,
    made: &WrittenLevel,
    target: &Target,
) -> ExtractReport {
    let finite = |x: f64| x.is_finite().then_some(x);
    let (error, rms) = made.largest;
    let mut objects = Vec::with_capacity(asset.objects.len());
    for (i, object) in asset.objects.iter().enumerate() {
        let (lod, mesh) = (level.lods[i], &level.meshes[i].mesh);
        let (error, rms) = made.of_objects[i];
        objects.push(ExtractedObject {
            name: object.info.name.clone(),
            lod: lod.map(|lod| lod.0),
            triangles: mesh.triangles().len() as u64,
            vertices: mesh.vertex_count() as u64,
            error: finite(error),
            rms: rms.and_then(finite),
            world_error: finite(object.info.world_scale * error),
            world_rms: rms.and_then(|rms| finite(object.info.world_scale * rms)),
        });
    }
    let triangles = objects.iter().map(|o| o.triangles).sum();
    let all: usize = asset.objects.iter().map(|o| o.simplified.mesh().triangles().len()).sum();
    ExtractReport {
        schema_version: SCHEMA_VERSION,
        status: 0,
        lod: single(&level.lods).flatten().map(|lod| lod.0),
        criterion: level.criterion.map(CriterionName::name),
        triangles,
        kept_share: if all == 0 { 1.0 } else { triangles as f64 / all as f64 },
        vertices: objects.iter().map(|o| o.vertices).sum(),
        error: finite(error),
        rms: rms.and_then(finite),
        errors_over: ErrorsOver::of(asset.objects.iter().map(|o| &o.info)),
        refitted: level.meshes.iter().any(|mesh| mesh.refitted),
        output: target.name(),
        input: input.display().to_string(),
        model: level.model,
        objects,
        gone: level.gone.clone(),
        warnings: [&asset.warnings[..], &level.warnings].concat(),
    }
}
