//! `lodc extract`: one level of detail as a mesh file.

mod one;

use super::asset::SimplifyArgs;
use super::each;
use crate::compression::CompressArgs;
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::kinds::{Choice, parser_with};
use crate::level_mesh::Order;
use crate::limits::ImportArgs;
use crate::mesh_output::{FormatName, Wanted};
use crate::output::{self, Target};
use crate::report::ExtractReport;
use crate::results::{self, FailureReport, ResultReport, reported};
use crate::selector::{SelectorArgs, bound};
use crate::text::{count, distance};
use crate::textures::TextureArgs;
use clap::Args;
use clap::builder::TypedValueParser;
use lodc_lod::ModelKind;
use std::path::{Path, PathBuf};

/// Options of `extract`.
#[derive(Args, Debug)]
pub(crate) struct ExtractArgs {
    /// Meshes (.obj, .gltf, .glb) or .lodc files; `-` for standard input
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Output: .glb, .gltf, .obj or .ply; a folder, for several inputs always; `-` for standard
    /// output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    selector: SelectorArgs,
    /// The level errs no more than E (mesh units; E%: of the diagonal), whatever else is wanted
    #[arg(long, value_name = "E", value_parser = bound)]
    max_error: Option<lodc_select::Target>,
    #[command(flatten)]
    simplify: SimplifyArgs,
    /// The structure that is replayed to get there [default: the first in the file]
    #[arg(long, value_parser = replays())]
    model: Option<Choice<ModelKind>>,
    /// The format, where OUT does not tell [default: glb]
    #[arg(long, value_enum)]
    format: Option<FormatName>,
    /// Move the vertices of the level to where they fit the input best; states the error measured
    #[arg(long)]
    refit: bool,
    /// The order of triangles and vertices
    #[arg(long, value_enum, default_value = "cache")]
    order: Order,
    #[command(flatten)]
    textures: TextureArgs,
    #[command(flatten)]
    compress: CompressArgs,
    /// Print what was extracted as JSON on standard output
    #[arg(long)]
    json: bool,
    /// Write a Make/Ninja dependency file that names every file read
    #[arg(long, value_name = "FILE")]
    depfile: Option<PathBuf>,
    #[command(flatten)]
    import: ImportArgs,
}

/// The names of all that may be replayed.
fn replays() -> impl TypedValueParser<Value = Choice<ModelKind>> {
    parser_with("reference", "The naive answer that every model is judged by")
}

pub(crate) fn run(args: &ExtractArgs) -> Outcome<Status> {
    let (targets, format) = reported(args.json, targets(args))?;
    let (mut worst, mut results, mut rules) = (Status::Done, Vec::new(), Vec::new());
    for (input, target) in args.inputs.iter().zip(&targets) {
        let made = each::guarded(input, || {
            one::extract(args, input, target.as_ref().map_err(Clone::clone)?, format)
        });
        results.push(match made {
            Ok((report, rule)) => {
                say(input, &report);
                rules.extend(rule);
                ResultReport::Done(report)
            }
            Err(failure) => {
                each::print(&failure);
                worst = worst.max(failure.status);
                ResultReport::Failed(FailureReport::of(input, &failure))
            }
        });
    }
    if let Some(depfile) = &args.depfile {
        output::write_depfile(depfile, &rules)?;
    }
    if args.json {
        results::print(args.inputs.len() > 1, worst, results)?;
    }
    Ok(worst)
}

/// The targets of all inputs and their format, once options are known to fit together.
fn targets(args: &ExtractArgs) -> Outcome<(Vec<Outcome<Target>>, FormatName)> {
    if args.inputs.iter().filter(|input| output::is_stream(input)).count() > 1 {
        return Err(Failure::usage("standard input can be read once only"));
    }
    let wanted = Wanted {
        inputs: &args.inputs,
        output: &args.output,
        format: args.format,
        json: args.json,
        depfile: args.depfile.as_deref(),
    };
    let (targets, format) = wanted.targets()?;
    args.compress.wanted(format, false)?;
    args.textures.check(format, targets.contains(&Ok(Target::Stdout)))?;
    Ok((targets, format))
}

/// Prints warnings and what was extracted.
fn say(input: &Path, report: &ExtractReport) {
    let name = input.display().to_string();
    for warning in &report.warnings {
        console::warning(&name, warning);
    }
    if wants(Loudness::Normal) {
        note(&sentence(report));
    }
}

fn sentence(report: &ExtractReport) -> String {
    let lod = report
        .lod
        .map_or_else(|| format!("{} objects", report.objects.len()), |lod| format!("LOD {lod}"));
    let output = if report.output == "-" { "standard output" } else { &report.output };
    format!(
        "{output}: {lod}, {}, {}, error {}{}",
        count(report.triangles, "triangle"),
        count(report.vertices, "vertex"),
        distance(report.error.unwrap_or(f64::INFINITY)),
        if report.refitted { " (refitted)" } else { "" }
    )
}
