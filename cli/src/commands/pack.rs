//! `lodc pack`: turns a `.lodc` file into a progressive stream.

use super::build::counts;
use super::read::read_lodc;
use crate::bits;
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::help::{BECOMES, MORE, OUTPUT};
use crate::limits::LimitArgs;
use crate::output::{self, Target};
use crate::stages::Stages;
use clap::Args;
use lodc::{LodFile, LodObject};
use lodc_formats::Limits;
use lodc_formats::lods::{ErrorBound, PackOptions, Packed, PackedObject, Quantize, Unpacker, pack};
use lodc_report::SCHEMA_VERSION;
use lodc_report::documents::{BoundReport, PackReport, PackedReport, StreamBits};
use lodc_report::text::{count, distance, size};
use std::path::PathBuf;

/// Options of `pack`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct PackArgs {
    /// The .lodc file; - for standard input
    input: PathBuf,
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
    /// Stream, a .lods file, or folder; - for standard output
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT)]
    output: PathBuf,
    /// Print one JSON document on standard output
    #[arg(long, help_heading = OUTPUT)]
    json: bool,
    #[command(flatten)]
    limits: LimitArgs,
}

const EXAMPLES: &str = "\
Every prefix of a stream can be unpacked: the more of it, the finer the mesh.

Examples:
  lodc pack chair.lodc -o chair.lods
  lodc pack chair.lodc -o chair.lods --quantize pos=14,normal=10,uv=12";

fn quantize(text: &str) -> Result<Quantize, String> {
    let [position, normal, uv] = bits::bits_by_kind(text, ["pos", "normal", "uv"], &(2..=24))?;
    Ok(Quantize { position, normal, uv })
}

pub(crate) fn run(args: &PackArgs) -> Outcome<()> {
    let target = output::single_target(&args.input, Some(&args.output), "lods")?;
    output::prepare_targets([&target], output::is_folder(&args.output))?;
    if args.json && target == Target::Stdout {
        return Err(Failure::usage("the stream and the JSON do not fit one standard output"));
    }
    let mut stages = Stages::new(args.limits.clock(&args.input));
    let (file, _) = stages.run("read", || read_lodc(&args.input, args.limits.limits()))?;
    let quantize = args.quantize.unwrap_or_default();
    let options = PackOptions { quantize, exact: args.exact, ..PackOptions::default() };
    let packed = stages.run("pack", || pack(&file, &options))?;
    stages.run("check", || check(&packed))?;
    let report = report(args, &file, &packed, &target);
    stages.run("write", || output::write(&target, packed.bytes))?;
    if args.json {
        return console::json(&report);
    }
    if wants(Loudness::Normal) {
        note(&text(&report));
    }
    Ok(())
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

fn report(args: &PackArgs, file: &LodFile, packed: &Packed, target: &Target) -> PackReport {
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
        input: args.input.display().to_string(),
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
