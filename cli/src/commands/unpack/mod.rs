//! `lodc unpack`: writes the mesh of a stream or of a prefix of one, or the `.lodc` file of a
//! complete one.

mod mesh;
mod rebuilt;
mod summary;

use crate::exit::{Failure, Outcome, Status};
use crate::help::{MORE, OUTPUT, READ};
use crate::kinds::{ModelArgs, PosesArgs};
use crate::limits::LimitArgs;
use crate::mesh_output::FormatName;
use crate::stages::Stages;
use clap::Args;
use lodc_formats::lods::Unpacker;
use lodc_formats::{Assets, FormatError};
use lodc_report::text::count;
use std::path::PathBuf;

/// Options of `unpack`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct UnpackArgs {
    /// The .lods stream, or any prefix of one; - for standard input
    input: PathBuf,
    #[command(flatten)]
    models: ModelArgs,
    #[command(flatten)]
    poses: PosesArgs,
    /// File (.glb, .gltf, .obj, .ply or .lodc), or folder; - for standard output
    ///
    /// A .lodc file needs the whole stream.
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT)]
    output: PathBuf,
    /// Format, if the name of OUT does not say [default: glb]
    #[arg(long, value_enum, help_heading = OUTPUT)]
    format: Option<FormatName>,
    /// Print one JSON document on standard output
    #[arg(long, help_heading = OUTPUT)]
    json: bool,
    /// Fail with status 3 unless the stream is complete
    #[arg(long, help_heading = READ)]
    whole: bool,
    #[command(flatten)]
    limits: LimitArgs,
}

const EXAMPLES: &str = "\
A stream that ends early is a normal case: what has come is a complete mesh. One that is damaged \
gives the part before the damage and ends with status 3.

Examples:
  lodc unpack chair.lods -o chair.glb
  lodc unpack - -o early.obj
  lodc unpack chair.lods -o chair.lodc --models none";

pub(crate) fn run(args: &UnpackArgs) -> Outcome<Status> {
    // A file with all levels; else the mesh that has come.
    if rebuilt::is_wanted(args) {
        return rebuilt::run(args);
    }
    if args.models.is_given() {
        return Err(Failure::usage("--models and --layout need -o F.lodc: a mesh has neither"));
    }
    mesh::run(args)
}

/// A stream as far as it can be used.
struct Stream {
    /// For messages.
    name: String,
    unpacker: Unpacker,
    /// What is wrong with the first part that cannot be used.
    damaged: Option<FormatError>,
}

/// Reads the input into an unpacker.
fn read(args: &UnpackArgs, mut unpacker: Unpacker, stages: &mut Stages) -> Outcome<Stream> {
    let mut assets = Assets::new(&args.input, &[], args.limits.limits());
    let name = assets.main_name();
    let bytes = stages.run("read", || assets.read_main())?;
    let damaged = stages.run("unpack", || unpacker.feed(&bytes)).err().map(|e| e.in_file(&name));
    Ok(Stream { name, unpacker, damaged })
}

/// The warning about an object of which quantising has flattened triangles, if it has.
fn flattened(object: &str, triangles: usize) -> Option<String> {
    let triangles = (triangles > 0).then(|| count(triangles as u64, "triangle"))?;
    Some(format!("{object}: {triangles} without area after quantising left out"))
}
