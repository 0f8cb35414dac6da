//! `lodc extract`: one level of detail as a mesh file.

use super::read::read_lodc;
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::levels::{self, ModelName};
use crate::limits::LimitArgs;
use crate::output::{self, Rule, Target};
use crate::report::{ExtractReport, ExtractedObject, SCHEMA_VERSION};
use crate::selector::{SelectorArgs, decimal, select};
use crate::stages::Stages;
use crate::text::{count, distance};
use clap::{Args, ValueEnum};
use lodc_formats::OutputFile;
use lodc_formats::export::{ExportFormat, ExportObject, export};
use lodc_formats::lodc::{LodFile, LodObject};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::{Lod, Mesh};
use rayon::prelude::*;
use std::path::PathBuf;

/// Options of `extract`.
#[derive(Args, Debug)]
pub(crate) struct ExtractArgs {
    /// The .lodc file; `-` for standard input
    input: PathBuf,
    /// Where to write: .glb, .gltf, .obj or .ply; a folder; `-` for standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    selector: SelectorArgs,
    /// The structure that is replayed to get there [default: the first in the file]
    #[arg(long, value_enum)]
    model: Option<ReplayName>,
    /// The format, where OUT does not tell [default: glb]
    #[arg(long, value_enum)]
    format: Option<FormatName>,
    /// Print what was extracted as JSON on standard output
    #[arg(long)]
    json: bool,
    /// Write a Make/Ninja dependency file that names every file read
    #[arg(long, value_name = "FILE")]
    depfile: Option<PathBuf>,
    #[command(flatten)]
    limits: LimitArgs,
}

/// What may be replayed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ReplayName {
    Speed,
    Masking,
    Interactive,
    /// The naive answer that every model is judged by
    Reference,
}

impl ReplayName {
    fn model(self) -> Option<ModelName> {
        match self {
            Self::Speed => Some(ModelName::Speed),
            Self::Masking => Some(ModelName::Masking),
            Self::Interactive => Some(ModelName::Interactive),
            Self::Reference => None,
        }
    }
}

/// Formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FormatName {
    Glb,
    Gltf,
    Obj,
    Ply,
}

impl FormatName {
    fn extension(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::Ply => "ply",
        }
    }
    fn format(self) -> ExportFormat {
        match self {
            Self::Glb => ExportFormat::Glb,
            Self::Gltf => ExportFormat::Gltf,
            Self::Obj => ExportFormat::Obj,
            Self::Ply => ExportFormat::Ply,
        }
    }
}

pub(crate) fn run(args: &ExtractArgs) -> Outcome<()> {
    let (target, format) = target(args)?;
    let mut stages = Stages::default();
    let (file, _) = stages.run("read", || read_lodc(&args.input, args.limits.limits()))?;
    let model = model(args, &file)?;
    let candidates = levels::candidates(&file.objects);
    let chosen = select(&candidates, args.selector.target(), args.selector.per_object())?;
    let meshes = stages.run("extract", || meshes(&file.objects, &chosen.lods, model))?;
    let files = stages.run("export", || {
        let objects: Vec<_> =
            file.objects.iter().zip(&meshes).map(|(o, mesh)| ExportObject { info: &o.info, mesh }).collect();
        let path = match &target {
            Target::File(path) => path.clone(),
            Target::Stdout => PathBuf::from("stdout").with_extension(format.extension()),
        };
        export(&path, format.format(), &file.document, &objects)
    })?;
    stages.run("write", || write(&target, files))?;
    if let (Some(depfile), Target::File(path)) = (&args.depfile, &target) {
        output::write_depfile(depfile, &[Rule { output: path.clone(), inputs: vec![args.input.clone()] }])?;
    }

    let report = report(args, &file, &chosen.lods, &meshes, chosen.error, chosen.warnings, model, &target);
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

/// Where the result goes, and in which format.
fn target(args: &ExtractArgs) -> Outcome<(Target, FormatName)> {
    if output::is_stream(&args.output) {
        let format = args.format.unwrap_or(FormatName::Glb);
        if args.json {
            return Err(Failure::usage("the mesh and the JSON do not fit one standard output"));
        }
        if format == FormatName::Gltf {
            return Err(Failure::usage("a .gltf has a .bin beside it: write .glb to standard output instead"));
        }
        if args.depfile.is_some() {
            return Err(Failure::usage("a dependency file needs an output file, not standard output"));
        }
        return Ok((Target::Stdout, format));
    }
    let folder = output::is_folder(&args.output);
    let format = if folder { args.format.unwrap_or(FormatName::Glb) } else { format(args)? };
    let inputs = std::slice::from_ref(&args.input);
    let targets = output::targets(inputs, Some(&args.output), format.extension())?;
    output::prepare(&targets, folder)?;
    if let Some(depfile) = &args.depfile {
        if output::is_stream(depfile) || *depfile == args.output || *depfile == args.input {
            return Err(Failure::usage("the dependency file needs a name of its own"));
        }
        output::prepare(&[Target::File(depfile.clone())], false)?;
    }
    let target = targets.into_iter().next().expect("one input has one target");
    Ok((target, format))
}

/// The format by option or by the extension of OUT.
fn format(args: &ExtractArgs) -> Outcome<FormatName> {
    if let Some(format) = args.format {
        return Ok(format);
    }
    let extension = args.output.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    FormatName::from_str(&extension, true).map_err(|_| {
        Failure::usage(format!(
            "{}: the extension names no known format: use .glb, .gltf, .obj or .ply, or say --format",
            args.output.display()
        ))
    })
}

/// The model to replay; none stands for the reference.
fn model(args: &ExtractArgs, file: &LodFile) -> Outcome<Option<ModelKind>> {
    let stored = || file.objects.first().into_iter().flat_map(|o| o.models.iter().map(AnyModel::kind));
    let Some(name) = args.model else { return Ok(stored().next()) };
    let Some(wanted) = name.model().map(ModelName::kind) else { return Ok(None) };
    if file.objects.is_empty() || stored().any(|kind| kind == wanted) {
        return Ok(Some(wanted));
    }
    let has: Vec<_> = stored().map(ModelKind::name).collect();
    Err(Failure::usage(format!(
        "{}: has no model {} (it has: {}, reference)",
        args.input.display(),
        wanted.name(),
        has.join(", ")
    )))
}

fn meshes(objects: &[LodObject], lods: &[Lod], model: Option<ModelKind>) -> Outcome<Vec<Mesh>> {
    let one = |(object, &lod): (&LodObject, &Lod)| {
        let live = levels::triangles(object, model, lod);
        object
            .simplified
            .mesh()
            .extract(&live)
            .map_err(|e| Failure::new(Status::Bug, format!("{}: LOD {} is no mesh: {e}", object.info.name, lod.0)))
    };
    objects.par_iter().zip(lods).map(one).collect()
}

fn write(target: &Target, files: Vec<OutputFile>) -> Outcome<()> {
    match target {
        Target::File(_) => output::commit(&files),
        // Standard output takes the mesh; what stands beside it (an MTL) has no place there.
        Target::Stdout => files.into_iter().next().map_or(Ok(()), |first| console::bytes(&first.bytes)),
    }
}

#[expect(clippy::too_many_arguments, reason = "it gathers what the steps above have found out")]
fn report(
    args: &ExtractArgs,
    file: &LodFile,
    lods: &[Lod],
    meshes: &[Mesh],
    error: f64,
    warnings: Vec<String>,
    model: Option<ModelKind>,
    target: &Target,
) -> ExtractReport {
    let object = |((object, &lod), mesh): ((&LodObject, &Lod), &Mesh)| ExtractedObject {
        name: object.info.name.clone(),
        lod: lod.0,
        triangles: mesh.triangles().len() as u64,
        vertices: mesh.vertex_count() as u64,
        error: decimal(object.simplified.collapses().error_at(lod)),
    };
    let objects: Vec<_> = file.objects.iter().zip(lods).zip(meshes).map(object).collect();
    ExtractReport {
        schema_version: SCHEMA_VERSION,
        lod: match lods {
            [one] => Some(one.0),
            _ => None,
        },
        triangles: objects.iter().map(|o| o.triangles).sum(),
        vertices: objects.iter().map(|o| o.vertices).sum(),
        error,
        output: target.name(),
        input: args.input.display().to_string(),
        model: model.map_or("reference", ModelKind::name),
        objects,
        warnings,
    }
}

fn sentence(report: &ExtractReport) -> String {
    let lod = report.lod.map_or_else(|| format!("{} objects", report.objects.len()), |lod| format!("LOD {lod}"));
    let output = if report.output == "-" { "standard output" } else { &report.output };
    format!(
        "{output}: {lod}, {}, {}, error {}",
        count(report.triangles, "triangle"),
        count(report.vertices, "vertex"),
        distance(report.error)
    )
}
