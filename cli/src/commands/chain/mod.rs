//! `lodc chain`: a few levels for engines, over one vertex buffer or as a file each.

mod levels;
mod separate;
mod shared;

use super::asset::{self, Asset, SimplifyArgs};
use crate::compression::CompressArgs;
use crate::console::{self, Loudness, result, wants};
use crate::exit::{Failure, Outcome};
use crate::limits::ImportArgs;
use crate::mesh_output::FormatName;
use crate::output::{self, Rule, Target};
use crate::report::{ChainReport, SCHEMA_VERSION};
use crate::results::reported;
use crate::selector::{SceneLevels, bound};
use crate::stages::Stages;
use crate::text::{distance, grouped, size};
use crate::textures::TextureArgs;
use clap::Args;
use levels::{Level, LevelArgs};
use lodc_formats::OutputFile;
use lodc_formats::export::{Additions, LevelFacts, Provenance};
use std::path::PathBuf;

/// Options of `chain`.
#[derive(Args, Debug)]
#[command(after_help = "With no option for levels, --levels 100%,50%,25%,10% is taken.")]
pub(crate) struct ChainArgs {
    /// A mesh (.obj, .gltf, .glb) or a .lodc file; `-` for standard input
    input: PathBuf,
    /// Output: .glb or .gltf; with --separate also .obj or .ply
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    levels: LevelArgs,
    /// No level errs more than E (mesh units; E%: of the diagonal), however few triangles are
    /// wanted
    #[arg(long, value_name = "E", value_parser = bound)]
    max_error: Option<lodc_select::Target>,
    /// Write a file per level: STEM_LOD0.EXT, STEM_LOD1.EXT, ...
    #[arg(long)]
    separate: bool,
    /// Put all levels into one index accessor per primitive, their ranges into `extras`
    #[arg(long, conflicts_with = "separate")]
    index_ranges: bool,
    /// Move the vertices of each level to where they fit the input best (needs --separate)
    #[arg(long, requires = "separate")]
    refit: bool,
    #[command(flatten)]
    simplify: SimplifyArgs,
    #[command(flatten)]
    textures: TextureArgs,
    #[command(flatten)]
    compress: CompressArgs,
    /// Print the levels as JSON on standard output
    #[arg(long)]
    json: bool,
    /// Write a Make/Ninja dependency file that names every file read
    #[arg(long, value_name = "FILE")]
    depfile: Option<PathBuf>,
    #[command(flatten)]
    import: ImportArgs,
}

/// Files of a chain, each with the levels in it, by their place in the table.
struct Files {
    files: Vec<OutputFile>,
    /// The main file of each level.
    of_level: Vec<PathBuf>,
}

pub(crate) fn run(args: &ChainArgs) -> Outcome<()> {
    reported(args.json, chain(args))
}

fn chain(args: &ChainArgs) -> Outcome<()> {
    let format = format(args)?;
    args.textures.check(format, false)?;
    args.compress.wanted(format, false)?;
    output::prepare(&[Target::File(args.output.clone())], true)?;
    let mut stages = Stages::default();
    let asset = asset::read(&args.input, &args.import, &args.simplify, &mut stages)?;
    let name = args.input.display().to_string();
    let limits = args.import.limits().limits();
    let scene = SceneLevels::new(&asset.objects, &asset.document, &limits)?;
    let (mut levels, mut warnings) = args.levels.choose(&asset.objects, &scene, args.max_error)?;
    warnings.splice(0..0, asset.warnings.iter().cloned());
    let target = Target::File(args.output.clone());
    let textures = stages.run("textures", || {
        args.textures.placed(&asset.document, &args.input, &args.import, &target, format)
    });
    let (textures, images_read) = textures?;
    warnings.extend_from_slice(&textures.warnings);
    let compress = args.compress.wanted(format, asset.compressed)?;
    let additions = Additions { textures, compress, provenance: None };
    let made = stages.run("export", || match args.separate {
        true => separate::files(args, format, &asset, &mut levels, additions),
        false => shared::files(args, format, &asset, &mut levels, additions),
    })?;
    stages.run("write", || output::commit(&made.files))?;
    write_depfile(args, &made, &[asset.files_read, images_read].concat())?;
    for warning in &warnings {
        console::warning(&name, warning);
    }
    report(args, &levels, &made, warnings)
}

/// The format by the extension of OUT.
fn format(args: &ChainArgs) -> Outcome<FormatName> {
    if output::is_stream(&args.output) || output::is_folder(&args.output) {
        let name = args.output.display();
        return Err(Failure::usage(format!("{name}: a chain needs the name of a file")));
    }
    let format = FormatName::by_extension(&args.output)?;
    if !args.separate && !matches!(format, FormatName::Glb | FormatName::Gltf) {
        return Err(Failure::usage(format!(
            "{}: only .glb and .gltf hold several levels: add --separate for a file per level",
            args.output.display()
        )));
    }
    Ok(format)
}

/// The origin of a file with these levels.
fn provenance(args: &ChainArgs, asset: &Asset, levels: &[Level]) -> Provenance {
    let facts = |level: &Level| LevelFacts {
        lod: level.lod(),
        error: level.error,
        rms: level.rms.filter(|rms| rms.is_finite()),
    };
    Provenance {
        source: asset.source.content_hash,
        levels: levels.iter().map(facts).collect(),
        refitted: args.refit,
    }
}

fn write_depfile(args: &ChainArgs, made: &Files, inputs: &[PathBuf]) -> Outcome<()> {
    let Some(depfile) = &args.depfile else { return Ok(()) };
    let mut outputs = made.of_level.clone();
    outputs.dedup();
    let rule = |output| Rule { output, inputs: inputs.to_owned() };
    let rules: Vec<Rule> = outputs.into_iter().map(rule).collect();
    output::write_depfile(depfile, &rules)
}

fn report(args: &ChainArgs, levels: &[Level], made: &Files, warnings: Vec<String>) -> Outcome<()> {
    let report = ChainReport {
        schema_version: SCHEMA_VERSION,
        input: args.input.display().to_string(),
        outputs: made.files.iter().map(Into::into).collect(),
        levels: levels
            .iter()
            .zip(&made.of_level)
            .enumerate()
            .map(|(level, (l, path))| l.report(level, path))
            .collect(),
        warnings,
    };
    if args.json {
        return console::json(&report);
    }
    if !wants(Loudness::Normal) {
        return Ok(());
    }
    result(" level   triangles    vertices       error         rms    distance")?;
    for l in &report.levels {
        let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), distance);
        result(&format!(
            "{:6} {:>11} {:>11} {:>11} {:>11} {:>11}",
            l.level,
            grouped(l.triangles),
            grouped(l.vertices),
            number(l.error),
            number(l.rms),
            number(l.distance)
        ))?;
    }
    for file in &report.outputs {
        result(&format!("{}: {}", file.path, size(file.bytes)))?;
    }
    Ok(())
}
