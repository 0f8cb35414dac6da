//! `lodc extract`: one level of detail as a mesh file.

use super::read::read_lodc;
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::kinds::{Choice, parser_with};
use crate::levels;
use crate::limits::LimitArgs;
use crate::mesh_output::{self, FormatName, Wanted};
use crate::output::{self, Rule, Target};
use crate::report::{ExtractReport, ExtractedObject, SCHEMA_VERSION};
use crate::selector::{SceneLevels, SelectorArgs};
use crate::stages::Stages;
use crate::text::{count, distance};
use clap::Args;
use clap::builder::TypedValueParser;
use lodc_formats::export::ExportObject;
use lodc_formats::lodc::{LodFile, LodObject};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::{Lod, Mesh};
use lodc_select::{Selection, decimal};
use rayon::prelude::*;
use std::path::PathBuf;

/// Options of `extract`.
#[derive(Args, Debug)]
pub(crate) struct ExtractArgs {
    /// The .lodc file; `-` for standard input
    input: PathBuf,
    /// Output: .glb, .gltf, .obj or .ply; a folder; `-` for standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    selector: SelectorArgs,
    /// The structure that is replayed to get there [default: the first in the file]
    #[arg(long, value_parser = replays())]
    model: Option<Choice<ModelKind>>,
    /// The format, where OUT does not tell [default: glb]
    #[arg(long, value_enum)]
    format: Option<FormatName>,
    /// Move the vertices of the level to where they fit the input best
    #[arg(long)]
    refit: bool,
    /// Print what was extracted as JSON on standard output
    #[arg(long)]
    json: bool,
    /// Write a Make/Ninja dependency file that names every file read
    #[arg(long, value_name = "FILE")]
    depfile: Option<PathBuf>,
    #[command(flatten)]
    limits: LimitArgs,
}

/// The names of all that may be replayed.
fn replays() -> impl TypedValueParser<Value = Choice<ModelKind>> {
    parser_with("reference", "The naive answer that every model is judged by")
}

pub(crate) fn run(args: &ExtractArgs) -> Outcome<()> {
    let wanted = Wanted {
        input: &args.input,
        output: &args.output,
        format: args.format,
        json: args.json,
        depfile: args.depfile.as_deref(),
    };
    let (target, format) = wanted.target()?;
    let mut stages = Stages::default();
    let (file, _) = stages.run("read", || read_lodc(&args.input, args.limits.limits()))?;
    let model = model(args, &file)?;
    let choice = SceneLevels::new(&file.objects, &file.document, &args.limits.limits())?;
    let chosen = stages
        .run("select", || choice.select(args.selector.target(), args.selector.per_object()))?;
    let meshes = stages.run("extract", || match args.refit {
        true => Ok(refitted(&file.objects, &chosen.lods)),
        false => meshes(&file.objects, &chosen.lods, model),
    })?;
    let files = stages.run("export", || {
        let objects: Vec<_> = file
            .objects
            .iter()
            .zip(&meshes)
            .map(|(o, mesh)| ExportObject { info: &o.info, mesh })
            .collect();
        mesh_output::files(&target, format, &file.document, &objects)
    })?;
    stages.run("write", || mesh_output::write(&target, files))?;
    if let (Some(depfile), Target::File(path)) = (&args.depfile, &target) {
        output::write_depfile(
            depfile,
            &[Rule { output: path.clone(), inputs: vec![args.input.clone()] }],
        )?;
    }

    let report = report(args, &file, &meshes, chosen, model, &target);
    let input = args.input.display().to_string();
    for warning in &report.warnings {
        console::warning(&input, warning);
    }
    if args.json {
        return console::json(&report);
    }
    if wants(Loudness::Normal) {
        note(&sentence(&report));
    }
    Ok(())
}

/// The model to replay; none stands for the reference.
fn model(args: &ExtractArgs, file: &LodFile) -> Outcome<Option<ModelKind>> {
    let stored =
        || file.objects.first().into_iter().flat_map(|o| o.models.iter().map(AnyModel::kind));
    let Some(name) = args.model else { return Ok(stored().next()) };
    let Some(wanted) = name.kind() else { return Ok(None) };
    if file.objects.is_empty() || stored().any(|kind| kind == wanted) {
        return Ok(Some(wanted));
    }
    let has: Vec<_> = stored().map(ModelKind::name).chain(["reference"]).collect();
    Err(Failure::usage(format!(
        "{}: has no model {} (it has: {})",
        args.input.display(),
        wanted.name(),
        has.join(", ")
    )))
}

fn refitted(objects: &[LodObject], lods: &[Lod]) -> Vec<Mesh> {
    let one = |(object, &lod): (&LodObject, &Lod)| {
        lodc_refit::refit(&object.simplified, lod, &lodc_refit::Options::DEFAULT)
    };
    objects.iter().zip(lods).map(one).collect()
}

fn meshes(objects: &[LodObject], lods: &[Lod], model: Option<ModelKind>) -> Outcome<Vec<Mesh>> {
    let one = |(object, &lod): (&LodObject, &Lod)| {
        let live = levels::triangles(object, model, lod);
        object.simplified.mesh().extract(&live).map_err(|e| {
            Failure::new(
                Status::Bug,
                format!("{}: LOD {} is no mesh: {e}", object.info.name, lod.0),
            )
        })
    };
    objects.par_iter().zip(lods).map(one).collect()
}

fn report(
    args: &ExtractArgs,
    file: &LodFile,
    meshes: &[Mesh],
    chosen: Selection,
    model: Option<ModelKind>,
    target: &Target,
) -> ExtractReport {
    let object = |((object, &lod), mesh): ((&LodObject, &Lod), &Mesh)| ExtractedObject {
        name: object.info.name.clone(),
        lod: lod.0,
        triangles: mesh.triangles().len() as u64,
        vertices: mesh.vertex_count() as u64,
        error: decimal(object.simplified.collapses().error_at(lod)),
        rms: object.simplified.collapses().rms_at(lod).map(decimal),
    };
    let objects: Vec<_> = file.objects.iter().zip(&chosen.lods).zip(meshes).map(object).collect();
    ExtractReport {
        schema_version: SCHEMA_VERSION,
        lod: match chosen.lods[..] {
            [one] => Some(one.0),
            _ => None,
        },
        triangles: objects.iter().map(|o| o.triangles).sum(),
        vertices: objects.iter().map(|o| o.vertices).sum(),
        error: chosen.error,
        rms: chosen.rms,
        output: target.name(),
        input: args.input.display().to_string(),
        model: model.map_or("reference", ModelKind::name),
        objects,
        warnings: chosen.warnings,
    }
}

fn sentence(report: &ExtractReport) -> String {
    let lod = report
        .lod
        .map_or_else(|| format!("{} objects", report.objects.len()), |lod| format!("LOD {lod}"));
    let output = if report.output == "-" { "standard output" } else { &report.output };
    format!(
        "{output}: {lod}, {}, {}, error {}",
        count(report.triangles, "triangle"),
        count(report.vertices, "vertex"),
        distance(report.error)
    )
}
