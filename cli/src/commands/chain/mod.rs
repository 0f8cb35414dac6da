//! `lodc chain`: a few levels for engines, over one vertex buffer or as a file each. With
//! `--geomorph` a level *morphs* to the next: a morph target moves its vertices there.

mod geomorph;
mod levels;
mod separate;
mod shared;
mod summary;
mod written;

use super::asset;
use super::each::{self, JobOptions};
use super::export::ExportArgs;
use super::records::Wanted;
use super::runs::JobResult;
use crate::batch::Job;
use crate::compression::EncodeOptions;
use crate::console;
use crate::exit::{Failure, Outcome, Status};
use crate::help::{BECOMES, LEVEL, MORE, OUTPUT};
use crate::mesh_output::{self, FormatName};
use crate::output::{self, DependencyRule, Target};
use crate::program::Program;
use crate::progress::Progress;
use crate::results::print_failure;
use crate::rounding::Room;
use crate::selector::bound;
use crate::stages::Stages;
use clap::Args;
use levels::{ChosenLevel, LevelArgs, Measured};
use lodc::level_mesh::Order;
use lodc::pipeline::{Growth, refitted_meshes};
use lodc::{Errors, SceneLevels, parting_borders, parting_line, scene_levels};
use lodc_formats::export::{LevelFacts, Provenance};
use lodc_formats::{Limits, ObjectInfo, OutputFile, RequestedFiles, scene_graph};
use lodc_mesh::Lod;
use lodc_report::documents::ChainReport;
use lodc_report::{ErrorsOver, PartInventory};
use std::path::{Path, PathBuf};

/// Options of `chain`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct ChainArgs {
    /// Meshes (.glb, .gltf, .obj, .ply, .stl), .lodc files, or folders; - for standard input
    #[arg(value_name = "INPUT", required_unless_present = "manifest")]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    levels: LevelArgs,
    /// Error of at most E (or E%) in every level
    ///
    /// It counts before the number of triangles that is asked for.
    #[arg(long, value_name = "E", value_parser = bound, help_heading = LEVEL)]
    max_error: Option<lodc_select::Target>,
    #[command(flatten)]
    export: ExportArgs,
    /// A file for each level: STEM_LOD0.EXT, ...
    #[arg(long, help_heading = BECOMES, display_order = 0)]
    separate: bool,
    /// All levels in one index accessor for each primitive
    ///
    /// extras.lodc.levels of the accessor says where each begins.
    #[arg(long, conflicts_with = "separate", help_heading = BECOMES, display_order = 1,
          hide_short_help = true)]
    index_ranges: bool,
    #[command(flatten)]
    geomorph: geomorph::GeomorphArgs,
    /// Move vertices to where they fit the input best
    ///
    /// Needs --separate. Errors are measured on the result.
    #[arg(long, requires = "separate", help_heading = BECOMES, display_order = 2,
          hide_short_help = true)]
    refit: bool,
    /// File (.glb, .gltf; --separate: any), or folder
    ///
    /// For several inputs always a folder. A folder that is there, or a name with / at its end,
    /// means a file inside it. There club.obj becomes club.obj.glb; results of a folder keep its
    /// structure.
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT, display_order = 0)]
    output: PathBuf,
    /// Format, if the name of OUT does not say [default: glb]
    #[arg(long, value_enum, help_heading = OUTPUT, display_order = 0, hide_short_help = true)]
    format: Option<FormatName>,
    /// Every option that can change the result, as text.
    #[arg(skip)]
    options_text: String,
}

impl ChainArgs {
    /// Returns whether there is one input, in a small file.
    pub(crate) fn is_small(&self) -> bool {
        self.export.is_small(&self.inputs)
    }
}

const EXAMPLES: &str = "\
All levels share one vertex buffer, ordered by the last level that uses a vertex: each level needs \
a prefix only. \
Without --separate and --index-ranges the levels are tied together by MSFT_lod.

Examples:
  lodc chain chair.glb -o chair.levels.glb
  lodc chain chair.glb -o chair.obj --separate --levels 100%,10k,1k --refit
  lodc chain chair.glb -o chair.levels.glb --pixels 1 --distances 2,5,20 --geomorph";

/// Files of a chain, and which of them each level is in.
struct Files {
    files: Vec<OutputFile>,
    /// The main file of each level.
    of_level: Vec<PathBuf>,
    /// One line for each thing of the input that the format cannot hold, or holds at a price, and
    /// for each distance that quantising does not keep.
    warnings: Vec<String>,
}

/// What levels are of.
#[derive(Clone, Copy)]
struct Chained<'a> {
    asset: &'a lodc::Asset,
    scene: &'a SceneLevels<'a>,
    /// What was left for quantising when levels were chosen.
    room: &'a Room<'a>,
}

pub(crate) fn run(args: &ChainArgs, program: &Program) -> Outcome<Status> {
    let (jobs, format) = print_failure(args.export.run.reports(), jobs(args, program))?;
    let with_text = |args, options_text| ChainArgs { options_text, ..args };
    let options = JobOptions::new(program, "chain", &jobs, with_text);
    let several = args.export.batch.takes_many(&args.inputs);
    let need = |job: &Job| options.of(job).ok()?.export.need(&job.input);
    let done = each::all(&jobs, args.export.import.limits().budget(), need, |_, job, bar| {
        args.export.run.one(job, || {
            let (args, target) = options.ready(job)?;
            let Target::File(path) = target else { return Err(no_stream(&args.output)) };
            args.export.check(format, target)?;
            let beside = args.export.import.assets(&job.input, None);
            let (run, options) = (&args.export.run, &args.options_text);
            let wanted = Wanted::new(run, &job.input, target, &beside, options);
            if let Some(left) = wanted.and_then(Wanted::if_up_to_date) {
                return Ok(left);
            }
            let bar = bar.of_asset(&job.name);
            let (report, rules) = chain(args, (&job.input, path), wanted, format, &bar)?;
            summary::print(&report, several, args.export.run.reports())?;
            Ok(JobResult::done(report, rules))
        })
    });
    args.export.finish("chain", (&args.inputs, &args.output, format), &jobs, done)
}

/// The assets and the format of their results.
fn jobs(args: &ChainArgs, program: &Program) -> Outcome<(Vec<Job>, FormatName)> {
    if output::is_standard_stream(&args.output) {
        return Err(no_stream(&args.output));
    }
    let folder = args.export.batch.takes_many(&args.inputs) || output::is_folder(&args.output);
    let format = mesh_output::format(&args.output, args.format, folder)?;
    args.geomorph.check(format, &args.output)?;
    if !args.separate && !format.is_gltf() {
        return Err(Failure::usage(format!(
            "{}: only .glb and .gltf hold several levels: add --separate for a file per level",
            args.output.display()
        )));
    }
    let mut jobs = args.export.jobs((program, "chain"), &args.inputs, &args.output, format)?;
    jobs.iter_mut().for_each(|job| job.makes_folders = true);
    Ok((jobs, format))
}

fn no_stream(output: &Path) -> Failure {
    Failure::usage(format!("{}: a chain needs the name of a file or a folder", output.display()))
}

/// By object the number of nodes that show it.
fn showing_nodes(asset: &lodc::Asset, limits: &Limits) -> Outcome<Vec<usize>> {
    let infos: Vec<&ObjectInfo> = asset.objects.iter().map(|o| &o.info).collect();
    let graph = scene_graph(&asset.document, &infos, limits)?;
    let mut numbers = vec![0; infos.len()];
    for &object in graph.nodes.iter().flat_map(|node| &node.objects) {
        numbers[object as usize] += 1;
    }
    Ok(numbers)
}

/// By object whether a node shows it, where nodes tie levels together.
///
/// # Errors
/// If none does.
fn shown(args: &ChainArgs, asset: &lodc::Asset, limits: &Limits) -> Outcome<Option<Vec<bool>>> {
    if args.separate || args.index_ranges {
        return Ok(None);
    }
    let is_shown: Vec<bool> =
        showing_nodes(asset, limits)?.iter().map(|&nodes| nodes > 0).collect();
    if !is_shown.is_empty() && !is_shown.contains(&true) {
        return Err(Failure::new(
            Status::Input,
            "no node shows a mesh, and MSFT_lod ties levels together by nodes: --index-ranges and \
             --separate need none",
        ));
    }
    Ok(Some(is_shown))
}

/// Makes the chain of one input.
///
/// # Errors
/// If the input cannot be read, has no such levels, or the output cannot be written.
fn chain(
    args: &ChainArgs,
    (input, out): (&Path, &Path),
    wanted: Option<Wanted<'_>>,
    format: FormatName,
    progress: &Progress,
) -> Outcome<(ChainReport, Vec<DependencyRule>)> {
    // An asset may have options of its own.
    args.geomorph.check(format, out)?;
    let mut stages = Stages::new(args.export.import.clock(input));
    let (import, simplify) = (&args.export.import, &args.export.simplify);
    let errors = Errors::to_choose(args.levels.wanted().into_iter().chain(args.max_error));
    let asset = asset::read_showing(progress, input, import, simplify, errors, &mut stages)?;
    let limits = import.limits().limits();
    let mut scene = scene_levels(&asset.objects, &asset.document, &limits)?;
    let encoding = args.export.compress.wanted(format, asset.compressed)?;
    let is_shown = shown(args, &asset, &limits)?;
    let asked = args.levels.all_asked(args.max_error);
    let mut room = Room::new(&asset, format.export_format(), encoding.precision, &asked)?;
    let (chosen, measured) = loop {
        room.leave(&mut scene);
        let mut chosen = stages.run("select", || {
            args.levels.choose(&asset.objects, &scene, simplify.parts.all(), args.max_error)
        })?;
        if let Some(is_shown) = &is_shown {
            levels::keep_whole(&mut chosen, &asset.objects, is_shown);
        }
        let lods: Vec<&[Lod]> = chosen.iter().map(|level| &*level.lods).collect();
        if !args.refit {
            let distances = stages.checked("errors", |tick| asset.distances(&lods, tick))?;
            break (chosen, distances.into_iter().map(Measured::Plain).collect());
        }
        // Refitted levels are measured as they are made.
        let morphs = args.geomorph.moved_streams().is_some();
        let order = if morphs { Order::File } else { encoding.order() };
        let how = (order, Growth::from(errors));
        let refitted = stages.checked("refit", |tick| {
            let refitted = |lods: &&[Lod]| {
                refitted_meshes(&asset.objects, &asset.document, lods, how, &limits, tick)
            };
            lods.iter().map(refitted).collect::<Result<Vec<_>, _>>()
        })?;
        let mut has_grown = false;
        for (level, meshes) in chosen.iter().zip(&refitted) {
            has_grown |= room.make_more(&scene, &level.asked, meshes)?;
        }
        if !has_grown {
            let measured: Vec<Measured> = refitted.into_iter().map(Measured::Refitted).collect();
            break (chosen, measured);
        }
    };
    let inventory = PartInventory::new(&asset.objects, &scene, &asset.document)?;
    let (mut levels, mut warnings) =
        stages.run("gone", || levels::described(&asset.objects, chosen, measured, &inventory));
    if let Some(last) = levels.last() {
        let parting = parting_borders(&asset.objects, &last.lods, &asset.document, &limits)?;
        warnings.extend(parting_line(&parting));
    }
    warnings.splice(0..0, asset.warnings.iter().cloned());
    let target = Target::File(out.to_owned());
    let textures = stages.run("textures", || {
        args.export.textures.placed(&asset.document, input, import, &target, format)
    });
    let (textures, images) = textures?;
    warnings.extend_from_slice(&textures.warnings);
    if args.geomorph.moved_streams().is_some() {
        geomorph::check(&levels)?;
    }
    let encoded = |encoding: EncodeOptions, levels: &mut [ChosenLevel]| {
        let options = encoding.options(textures.clone());
        let input = Chained { asset: &asset, scene: &scene, room: &room };
        match args.separate {
            true if args.geomorph.moved_streams().is_some() => {
                separate::morphing_files(args, out, format, input, levels, options)
            }
            true => separate::files(out, format, input, levels, options),
            false => shared::files(args, out, format, input, levels, options),
        }
    };
    let mut alternative = encoding.alternative().map(|plain| (plain, levels.clone()));
    let mut made = stages.run("export", || encoded(encoding, &mut levels))?;
    if let Some((encoding, plain_levels)) = &mut alternative {
        let plain = stages.run("export", || encoded(*encoding, plain_levels))?;
        if let Some(line) = EncodeOptions::prefers_plain(&made.files, &plain.files) {
            warnings.push(line);
            levels.clone_from(plain_levels);
            made = plain;
        }
    }
    warnings.extend(made.warnings.iter().cloned());
    let mut read = asset.files;
    read.extend(&images);
    output::refuse_replacing(made.files.iter().map(|file| file.path.as_path()), &read)?;
    stages.run("write", || output::commit(&made.files))?;
    progress.clear();
    let name = input.display().to_string();
    console::warnings(&name, &warnings);
    let rules = rules(&made, &read);
    if let Some(wanted) = wanted {
        let outputs: Vec<PathBuf> = made.files.iter().map(|file| file.path.clone()).collect();
        wanted.record(&outputs, &rules, (&read, &images), &warnings)?;
    }
    let over = ErrorsOver::of(asset.objects.iter().map(|o| &o.info));
    Ok((summary::report(name, &levels, &made, warnings, over), rules))
}

/// The origin of a file with these levels.
fn provenance(args: &ChainArgs, asset: &lodc::Asset, levels: &[ChosenLevel]) -> Provenance {
    let facts = |level: &ChosenLevel| LevelFacts {
        lod: level.lod(),
        error: level.error,
        rms: level.rms.filter(|rms| rms.is_finite()),
        geomorph: level.geomorph,
    };
    Provenance {
        source: asset.source.content_hash,
        levels: levels.iter().map(facts).collect(),
        refitted: args.refit,
        screen: args.geomorph.moved_streams().map(|_| args.levels.screen()),
        next: None,
        poses: Some(asset.objects.iter().map(|o| o.info.poses.clone()).collect()),
    }
}

/// A rule for each file with levels, all made from the files that were `read`.
fn rules(made: &Files, read: &RequestedFiles) -> Vec<DependencyRule> {
    let mut outputs = made.of_level.clone();
    outputs.dedup();
    outputs.iter().map(|output| DependencyRule::new(output, read)).collect()
}
