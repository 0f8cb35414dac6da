//! `lodc unpack`: the mesh of a stream, or of as much of it as there is.

use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::limits::LimitArgs;
use crate::mesh_output::{self, FormatName, Wanted};
use crate::output::Target;
use crate::report::{SCHEMA_VERSION, UnpackReport, UnpackedReport};
use crate::stages::Stages;
use crate::text::{count, distance, grouped, size};
use clap::Args;
use lodc_formats::export::{Additions, ExportObject};
use lodc_formats::lods::{Arrived, Unpacker};
use lodc_formats::{Assets, FormatError};
use lodc_mesh::Mesh;
use lodc_select::decimal;
use std::path::PathBuf;

/// Options of `unpack`.
#[derive(Args, Debug)]
#[command(
    after_help = "A stream that ends early is a normal case: what has come is a complete mesh. \
                  One that is damaged gives the part before the damage and ends with status 3."
)]
pub(crate) struct UnpackArgs {
    /// The .lods stream, or any prefix of one; `-` for standard input
    input: PathBuf,
    /// Output: .glb, .gltf, .obj or .ply; a folder; `-` for standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Only a complete stream will do
    #[arg(long)]
    whole: bool,
    /// The format, if the name of OUT does not say [default: glb]
    #[arg(long, value_enum)]
    format: Option<FormatName>,
    /// Print what was unpacked as JSON on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limits: LimitArgs,
}

pub(crate) fn run(args: &UnpackArgs) -> Outcome<Status> {
    let wanted = Wanted {
        inputs: std::slice::from_ref(&args.input),
        output: &args.output,
        format: args.format,
        json: args.json,
        depfile: None,
    };
    let (target, format) = wanted.target()?;
    let mut stages = Stages::default();
    let limits = args.limits.limits();
    let mut assets = Assets::new(&args.input, &[], limits);
    let name = assets.main_name();
    let bytes = stages.run("read", || assets.read_main())?;
    let mut unpacker = Unpacker::new(limits).triangles_only();
    let damaged = stages.run("unpack", || unpacker.feed(&bytes)).err().map(|e| e.in_file(&name));
    let arrived = arrived(args, &unpacker, damaged.as_ref(), &name)?;

    let mut warnings = Vec::new();
    let meshes = meshes(&unpacker, &mut warnings).map_err(|e| e.in_file(&name))?;
    let objects: Vec<_> = (meshes.iter().enumerate())
        .map(|(i, mesh)| ExportObject { info: &arrived.infos[i], mesh })
        .collect();
    let document = &arrived.document;
    let files = stages.run("export", || {
        mesh_output::files(&target, format, document, &objects, &Additions::default())
    })?;
    stages.run("write", || mesh_output::write(&target, files))?;

    for warning in &warnings {
        console::warning(&name, warning);
    }
    let report = report(args, &unpacker, &arrived, damaged.as_ref(), warnings, &target);
    if args.json {
        console::json(&report)?;
    } else if wants(Loudness::Normal) {
        note(&sentence(&report));
    }
    match damaged {
        None => Ok(Status::Done),
        Some(error) => {
            let mut failure = Failure::from(error);
            failure.message += "; what stands before it was written";
            Err(failure)
        }
    }
}

/// Returns the mesh of each object so far.
fn meshes(unpacker: &Unpacker, warnings: &mut Vec<String>) -> Result<Vec<Mesh>, FormatError> {
    let mut meshes = Vec::new();
    for object in 0..unpacker.objects() {
        let (mesh, cleaning) = unpacker.mesh(object)?;
        if cleaning.degenerate_triangles > 0 {
            let triangles = count(cleaning.degenerate_triangles as u64, "triangle");
            warnings.push(format!(
                "{}: {triangles} without area after quantising left out",
                unpacker.info(object).name
            ));
        }
        meshes.push(mesh);
    }
    Ok(meshes)
}

/// Returns the document and the names so far; an error if nothing can be written.
fn arrived<'a>(
    args: &UnpackArgs,
    unpacker: &'a Unpacker,
    damaged: Option<&FormatError>,
    name: &str,
) -> Outcome<Arrived<'a>> {
    if let (Some(error), true) = (damaged, args.whole || unpacker.objects() == 0) {
        return Err(Failure::from(error.clone()));
    }
    if args.whole && !unpacker.is_complete() {
        return Err(Failure::new(Status::Input, format!("{name}: the stream is not complete")));
    }
    let arrived = unpacker.arrived().map_err(|e| Failure::from(e.in_file(name)))?;
    let is_empty = unpacker.objects() == 0 && !unpacker.is_complete();
    arrived.filter(|_| !is_empty).ok_or_else(|| {
        Failure::new(
            Status::Input,
            format!("{name}: the stream ends before there is anything to show"),
        )
    })
}

fn report(
    args: &UnpackArgs,
    unpacker: &Unpacker,
    arrived: &Arrived<'_>,
    damaged: Option<&FormatError>,
    warnings: Vec<String>,
    target: &Target,
) -> UnpackReport {
    let object = |i: usize| {
        let progress = unpacker.progress(i);
        let [vertices, of_vertices] = progress.vertices;
        let [triangles, of_triangles] = progress.triangles;
        let [steps, of_steps] = progress.steps;
        UnpackedReport {
            name: arrived.infos[i].name.clone(),
            vertices,
            of_vertices,
            triangles,
            of_triangles,
            steps,
            of_steps,
            error: decimal(progress.error),
        }
    };
    UnpackReport {
        schema_version: SCHEMA_VERSION,
        input: args.input.display().to_string(),
        output: target.name(),
        whole: unpacker.is_complete(),
        damaged: damaged.map(ToString::to_string),
        bytes: unpacker.bytes(),
        all_objects: unpacker.all_objects().unwrap_or(0),
        left_out: arrived.left_out.clone(),
        objects: (0..unpacker.objects()).map(object).collect(),
        warnings,
    }
}

fn sentence(report: &UnpackReport) -> String {
    let output = if report.output == "-" { "standard output" } else { &report.output };
    let sum = |of: fn(&UnpackedReport) -> u32| {
        report.objects.iter().map(|o| u64::from(of(o))).sum::<u64>()
    };
    let (triangles, all) = (sum(|o| o.triangles), sum(|o| o.of_triangles));
    let worst = report.objects.iter().map(|o| o.error).fold(0.0, f64::max);
    let bytes = size(report.bytes);
    if report.whole {
        return format!("{output}: {}, the whole stream of {bytes}", count(triangles, "triangle"));
    }
    // Objects that are still to come have not said how many triangles they have.
    let is_known = report.objects.len() == report.all_objects as usize && all > 0;
    let of = if is_known { format!(" of {}", grouped(all)) } else { String::new() };
    let mut text = format!(
        "{output}: {}{of} triangles, error {}: the stream ends after {bytes} that can be used",
        grouped(triangles),
        distance(worst)
    );
    if !report.left_out.is_empty() {
        text += &format!("\n{output}: still to come and left out: {}", report.left_out.join(", "));
    }
    text
}
