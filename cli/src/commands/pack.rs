//! `lodc pack`: turns a `.lodc` file into a progressive stream.

use super::building::counts;
use super::each::{self, JobOptions};
use super::prune::{PruneArgs, Written};
use super::read::read_lodc;
use super::records::Wanted;
use super::runs::{JobResult, RunArgs};
use crate::batch::{self, BatchArgs, CommandPaths, Job};
use crate::bits;
use crate::config::ConfigArgs;
use crate::console::{Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::help::{BECOMES, MORE, OUTPUT};
use crate::limits::LimitArgs;
use crate::output::{self, DependencyRule, Target};
use crate::program::Program;
use crate::stages::Stages;
use clap::Args;
use lodc::{LodFile, LodObject};
use lodc_formats::lods::{ErrorBound, PackOptions, Packed, PackedObject, Quantize, Unpacker, pack};
use lodc_formats::{Assets, Limits, RequestedFiles};
use lodc_report::SCHEMA_VERSION;
use lodc_report::documents::{BoundReport, PackReport, PackedReport, StreamBits};
use lodc_report::text::{count, distance, size};
use std::path::{Path, PathBuf};

/// Options of `pack`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct PackArgs {
    /// .lodc files, or folders of them; - for standard input
    #[arg(value_name = "INPUT", required_unless_present = "manifest")]
    inputs: Vec<PathBuf>,
    /// Bits per number: pos=16,normal=10,uv=12 [default: all]
    ///
    /// From 2 to 24; kinds left out stay as they are. Prints how far anything can move. Without it
    /// the whole stream gives back every bit.
    #[arg(long, value_name = "KIND=BITS,…", value_parser = quantize, help_heading = BECOMES)]
    quantize: Option<Quantize>,
    /// Keep the order of all steps
    ///
    /// Every level of the file is then in the stream, which is a quarter to a half larger. Else
    /// steps come in batches, and the levels at their ends are those of the file.
    #[arg(long, help_heading = BECOMES)]
    exact: bool,
    /// Stream, a .lods file, or folder for several inputs; - for standard output
    ///
    /// In a folder club.obj.lodc becomes club.obj.lods.
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT)]
    output: PathBuf,
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    prune: PruneArgs,
    #[command(flatten)]
    batch: BatchArgs,
    #[command(flatten)]
    configuration: ConfigArgs,
    #[command(flatten)]
    limits: LimitArgs,
    /// Every option that can change the result, as text.
    #[arg(skip)]
    options_text: String,
}

const EXAMPLES: &str = "\
Every prefix of a stream can be unpacked: the more of it, the finer the mesh.

Examples:
  lodc pack chair.lodc -o chair.lods
  lodc pack chair.lodc -o chair.lods --quantize pos=14,normal=10,uv=12
  lodc pack levels -o streams --if-changed";

fn quantize(text: &str) -> Result<Quantize, String> {
    let [position, normal, uv] = bits::bits_by_kind(text, ["pos", "normal", "uv"], &(2..=24))?;
    Ok(Quantize { position, normal, uv })
}

pub(crate) fn run(args: &PackArgs, program: &Program) -> Outcome<Status> {
    let paths = CommandPaths {
        inputs: &args.inputs,
        output: Some(&args.output),
        input_extensions: &["lodc"],
        output_extension: "lods",
        allowed_folders: &[],
    };
    let mut jobs = batch::jobs(paths, &args.batch)?;
    args.configuration.apply(program, "pack", &mut jobs)?;
    args.run.check(&jobs)?;
    let with_text = |args, options_text| PackArgs { options_text, ..args };
    let options = JobOptions::new(program, "pack", &jobs, with_text);
    let done = each::all(
        &jobs,
        args.limits.budget(),
        |_| None,
        |_, job, _| args.run.one(job, || pack_asset(job, &options)),
    );
    let several = args.batch.takes_many(&args.inputs);
    let status = args.run.finish("pack", several, &jobs, done)?;
    args.prune.sweep(paths, (&args.batch, &jobs), Written::Recorded)?;
    Ok(status)
}

/// Packs one file, unless its stream is up to date.
fn pack_asset(job: &Job, options: &JobOptions<PackArgs>) -> Outcome<JobResult<PackReport>> {
    let (args, target) = options.ready(job)?;
    let input = &job.input;
    let beside = Assets::new(input, &[], args.limits.limits());
    let wanted = Wanted::new(&args.run, input, target, &beside, &args.options_text);
    if let Some(left) = wanted.and_then(Wanted::if_up_to_date) {
        return Ok(left);
    }
    let report = pack_one(args, input, target)?;
    let files = RequestedFiles::from_path(input);
    let (outputs, rules) = match target {
        Target::File(path) => (vec![path.clone()], vec![DependencyRule::new(path, &files)]),
        Target::Stdout => (vec![], vec![]),
    };
    if let Some(wanted) = wanted {
        wanted.record(&outputs, &rules, (&files, &RequestedFiles::default()), &[])?;
    }
    if !args.run.reports() && wants(Loudness::Normal) {
        note(&text(&report));
    }
    Ok(JobResult::done(report, rules))
}

/// Writes the stream of a file.
fn pack_one(args: &PackArgs, input: &Path, target: &Target) -> Outcome<PackReport> {
    let mut stages = Stages::new(args.limits.clock(input));
    let (file, _) = stages.run("read", || read_lodc(input, args.limits.limits()))?;
    let quantize = args.quantize.unwrap_or_default();
    let options = PackOptions { quantize, exact: args.exact, ..PackOptions::default() };
    let packed = stages.run("pack", || pack(&file, &options))?;
    stages.run("check", || check(&packed))?;
    let report = report(input, &file, &packed, target);
    stages.run("write", || output::write(target, packed.bytes))?;
    Ok(report)
}

/// Unpacks what was packed, so that no wrong output is written.
fn check(packed: &Packed) -> Outcome<()> {
    let bug = |what: &str| Failure::new(Status::Bug, format!("the stream does not unpack: {what}"));
    let unlimited =
        Limits { file_bytes: u64::MAX, vertices: u64::MAX, triangles: u64::MAX, ..Limits::DEFAULT };
    let mut unpacker = Unpacker::new(unlimited);
    unpacker.feed(&packed.bytes).map_err(|e| bug(&e.to_string()))?;
    if unpacker.is_complete() { Ok(()) } else { Err(bug("something is missing")) }
}

fn report(input: &Path, file: &LodFile, packed: &Packed, target: &Target) -> PackReport {
    let bound = |b: &ErrorBound| BoundReport {
        stream: b.stream.clone(),
        bits: b.bits,
        coordinate: b.coordinate,
        distance: b.distance,
    };
    let object = |(o, p): (&LodObject, &PackedObject)| {
        let counts = counts(&o.info, &o.simplified);
        let bits_of = |bytes: u64| {
            if counts.referenced_vertices == 0 {
                0.0
            } else {
                8.0 * bytes as f64 / counts.referenced_vertices as f64
            }
        };
        let bits_per_vertex = StreamBits {
            stream: bits_of(p.bytes),
            packages: bits_of(p.package_bytes),
            packages_normals: bits_of(p.package_bytes_with_normals),
        };
        let bounds = p.bounds.iter().map(bound).collect();
        PackedReport {
            counts,
            exact_levels: p.exact_levels,
            levels: o.simplified.collapses().steps() as u32,
            bytes: p.bytes,
            bits_per_vertex,
            bounds,
        }
    };
    PackReport {
        schema_version: SCHEMA_VERSION,
        input: input.display().to_string(),
        output: target.name(),
        bytes: packed.bytes.len() as u64,
        head_bytes: packed.head_bytes,
        objects: file.objects.iter().zip(&packed.objects).map(object).collect(),
    }
}

fn text(report: &PackReport) -> String {
    let output = if report.output == "-" { "standard output" } else { &report.output };
    let head = size(report.head_bytes);
    let mut lines = vec![format!(
        "{output}: {}, of which {head} are names, nodes, materials and buffers",
        size(report.bytes)
    )];
    for o in &report.objects {
        let name = crate::exit::one_line(&o.counts.name);
        let vertices = count(o.counts.referenced_vertices, "vertex");
        let levels = if o.exact_levels < o.levels {
            format!(", {} of the file's {} levels are kept exactly", o.exact_levels, o.levels)
        } else {
            String::new()
        };
        let bits = o.bits_per_vertex.stream;
        lines.push(format!("  {name}: {vertices}, {bits:.1} bits each{levels}"));
        for b in &o.bounds {
            let (coordinate, far) = (distance(b.coordinate), distance(b.distance));
            lines.push(format!(
                "    {} in {} bits: off by at most {coordinate} in a coordinate, {far} in all",
                b.stream, b.bits
            ));
        }
    }
    lines.join("\n")
}
