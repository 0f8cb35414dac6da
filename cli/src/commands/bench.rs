//! `lodc bench`: storage, extraction time, bus traffic and primitives of every model and baseline
//! (thesis 3.5, 4.5, 5.5).

use super::asset::{self, SimplifyArgs};
use super::building::counts;
use super::each;
use super::read::read_lodc;
use crate::clock;
use crate::console;
use crate::exit::{Failure, Outcome, Status, one_line};
use crate::gpu::{self, Device, GpuArgs, GpuUse};
use crate::help::{MEASURED, MORE, OUTPUT};
use crate::kinds::{Choice, MetricArgs, StripArgs, models_or_all, parser_with};
use crate::limits::ImportArgs;
use crate::numbers::whole;
use crate::output::{self, Target};
use crate::progress::Progress;
use crate::stages::Stages;
use clap::Args;
use lodc::level_mesh::reference_meshes;
use lodc::{Asset, LodObject};
use lodc_formats::{images, import};
use lodc_lab::{
    BenchObject, CrowdReport, CrowdSettings, Input, LabError, Prepared, Settings, charts, crowd,
    crowd_charts, crowd_picture, crowd_table, measure, most_triangles, tables,
};
use lodc_lod::ModelKind;
use lodc_report::SCHEMA_VERSION;
use lodc_report::documents::ObjectCounts;
use lodc_report::text::{count, grouped};
use lodc_simplify::{MetricKind, Options, simplify};
use serde::Serialize;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Options of `bench`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct BenchArgs {
    /// Meshes (.glb, .gltf, .obj, .ply, .stl), or .lodc files with their models as they are
    #[arg(value_name = "INPUT", required = true)]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    metric: MetricArgs,
    /// Models to measure, separated by commas [default: all]
    ///
    /// Those that a .lodc file has not are made.
    #[arg(long, value_delimiter = ',', value_name = "MODELS",
          value_parser = parser_with::<ModelKind>("all", "Each of them"), help_heading = MEASURED)]
    models: Vec<Choice<ModelKind>>,
    /// Share of the LODs from one update to the next, in percent
    #[arg(long, value_name = "SHARE%", default_value = "0.1%", value_parser = share,
          help_heading = MEASURED, hide_short_help = true)]
    steps: f64,
    /// Rounds of timing, of which the best counts
    #[arg(long, value_name = "N", default_value = "5", value_parser = whole::<NonZeroU32>(1..),
          help_heading = MEASURED)]
    rounds: NonZeroU32,
    /// Leave out everything that differs from run to run
    #[arg(long, help_heading = MEASURED)]
    no_times: bool,
    /// Also pack each object as a progressive stream
    ///
    /// Its size, its speed, and how far its prefixes are from the whole.
    #[arg(long, help_heading = MEASURED)]
    streams: bool,
    #[command(flatten)]
    crowd: CrowdArgs,
    #[command(flatten)]
    strips: StripArgs,
    #[command(flatten)]
    pub(crate) gpu: GpuArgs,
    /// Print one JSON document on standard output
    #[arg(long, help_heading = OUTPUT)]
    json: bool,
    /// Write the curves as SVG files into a folder
    #[arg(long, value_name = "DIR", help_heading = OUTPUT)]
    plots: Option<PathBuf>,
    #[command(flatten)]
    import: ImportArgs,
}

const EXAMPLES: &str = "\
Everything is measured over the same collapse sequence, object by object, beside baselines that \
are never stored. Times are the best of several rounds in which everything takes turns; they \
differ from run to run. Everything else does not.

Examples:
  lodc bench chair.glb
  lodc bench chair.lodc --gpu --streams --json
  lodc bench figure.glb --crowd --plots charts --picture crowd.png";

fn share(text: &str) -> Result<f64, String> {
    match text.strip_suffix('%').unwrap_or(text).trim().parse::<f64>() {
        Ok(percent) if (1e-4..=100.0).contains(&percent) => Ok(percent / 100.0),
        _ => Err("not a percentage from 0.0001 to 100".to_owned()),
    }
}

impl BenchArgs {
    /// Rounds of timing; none if nothing is timed.
    fn rounds(&self) -> Option<u32> {
        (!self.no_times).then(|| self.rounds.get())
    }
}

/// Options of a crowd.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = MEASURED)]
struct CrowdArgs {
    /// Measure a crowd of all inputs instead
    ///
    /// It walks around a viewer, ten frames a second; every instance has a level by its distance.
    #[arg(long, conflicts_with = "streams")]
    crowd: bool,
    /// Instances of the crowd, up to 100,000
    #[arg(long, value_name = "N", default_value = "250", requires = "crowd",
          value_parser = whole::<u32>(1..=100_000), hide_short_help = true)]
    instances: u32,
    /// Seconds that it walks, up to 10,000
    #[arg(long, value_name = "S", default_value = "50", requires = "crowd",
          value_parser = whole::<u32>(1..=10_000), hide_short_help = true)]
    seconds: u32,
    /// Seed of its paths: the same number gives the same paths
    #[arg(long, value_name = "K", default_value = "1", value_parser = whole::<u64>(0..),
          requires = "crowd", hide_short_help = true)]
    seed: u64,
    /// Draw the crowd, all levels beside five
    #[arg(long, value_name = "OUT.png", requires = "crowd", help_heading = OUTPUT,
          hide_short_help = true)]
    picture: Option<PathBuf>,
}

/// `bench --json`.
#[derive(Debug, Serialize)]
struct BenchReport {
    schema_version: u32,
    tool_version: &'static str,
    /// Share of the LODs between two updates of a sweep.
    steps: f64,
    files: Vec<BenchFile>,
    /// Null if no crowd was asked for.
    crowd: Option<CrowdReport>,
}

/// One input.
#[derive(Debug, Serialize)]
struct BenchFile {
    file: String,
    error: Option<String>,
    objects: Vec<ObjectFigures>,
}

/// One object of an input.
#[derive(Debug, Serialize)]
struct ObjectFigures {
    #[serde(flatten)]
    counts: ObjectCounts,
    /// What of a large mesh is measured instead of all of it; null if all is.
    level: Option<String>,
    #[serde(flatten)]
    figures: BenchObject,
}

impl From<LabError> for Failure {
    fn from(error: LabError) -> Self {
        match error {
            LabError::Bug(what) => Self::new(Status::Bug, what),
            LabError::Limit(what) => Self::new(Status::Limit, what),
            LabError::Format(error) => error.into(),
            #[cfg(feature = "gpu")]
            LabError::Gpu(error) => gpu::failure(&error),
        }
    }
}

pub(crate) fn run(args: &BenchArgs) -> Outcome<Status> {
    if args.inputs.iter().filter(|input| output::is_standard_stream(input)).count() > 1 {
        return Err(Failure::usage("standard input can be read once only"));
    }
    if let Some(folder) = &args.plots {
        output::prepare_targets([&Target::File(folder.join("-"))], true)?;
    }
    if let Some(picture) = &args.crowd.picture {
        output::prepare_targets([&Target::File(picture.clone())], false)?;
    }
    let device = open(&args.gpu)?;
    let mut report = BenchReport {
        schema_version: SCHEMA_VERSION,
        tool_version: env!("CARGO_PKG_VERSION"),
        steps: args.steps,
        files: vec![],
        crowd: None,
    };
    if args.crowd.crowd {
        return run_crowd(args, device.as_ref(), report);
    }
    clock::expect_several(args.inputs.len() > 1);
    let mut worst = Status::Done;
    for input in &args.inputs {
        let (file, status) = bench_one(args, device.as_ref(), input);
        worst = worst.max(status);
        if !args.json && file.error.is_none() {
            console::result(text(&file, args.steps).trim_end())?;
        }
        report.files.push(file);
    }
    if let Some(folder) = &args.plots {
        write_plots(folder, plots(&report.files))?;
    }
    if args.json {
        console::json(&report)?;
    }
    Ok(worst)
}

/// Opens the device that was asked for; none if none was, or if it is optional and there is none.
fn open(args: &GpuArgs) -> Outcome<Option<Device>> {
    match (args.gpu, args.gpu.map(|_| gpu::open(args.adapter.as_deref()))) {
        (_, None) => Ok(None),
        (Some(GpuUse::Auto), Some(Err(failure))) => {
            console::note(&format!("nothing is timed on a GPU: {failure}"));
            Ok(None)
        }
        (_, Some(opened)) => opened.map(Some),
    }
}

/// Measures a crowd of all inputs, and nothing else.
fn run_crowd(
    args: &BenchArgs,
    device: Option<&Device>,
    mut report: BenchReport,
) -> Outcome<Status> {
    let whole = |input: &PathBuf| read(args, u64::MAX, input).map(|(input, _)| input);
    let inputs: Vec<Input> = args.inputs.iter().map(whole).collect::<Outcome<_>>()?;
    let CrowdArgs { instances, seconds, seed, .. } = args.crowd;
    let limits = args.import.options().limits;
    let settings = CrowdSettings { instances, seconds, seed, rounds: args.rounds(), limits };
    let figures = crowd(&inputs, &settings, device)?;
    if let Some(out) = &args.crowd.picture {
        let drawn = crowd_picture(&inputs, &settings)?;
        output::write(&Target::File(out.clone()), images::png(&drawn))?;
    }
    if let Some(folder) = &args.plots {
        write_plots(folder, crowd_charts(&figures))?;
    }
    if args.json {
        report.crowd = Some(figures);
        console::json(&report)?;
    } else {
        console::result(crowd_table(&figures).trim_end())?;
    }
    Ok(Status::Done)
}

/// Measures one input. A failure is in its report and does not stop the other inputs.
fn bench_one(args: &BenchArgs, device: Option<&Device>, input: &Path) -> (BenchFile, Status) {
    let name = input.display().to_string();
    let settings = Settings { steps: args.steps, rounds: args.rounds(), streams: args.streams };
    let measured = |(prepared, level): (&Prepared, Option<String>)| {
        let object = prepared.object();
        let counts = counts(&object.info, &object.simplified);
        Ok(ObjectFigures { counts, level, figures: measure(prepared, &settings, device)? })
    };
    let most = device.filter(|_| !args.no_times).map_or(u64::MAX, most_triangles);
    let work = || {
        let (input, levels) = read(args, most, input)?;
        input.objects.iter().zip(levels).map(measured).collect::<Outcome<Vec<_>>>()
    };
    let failure = match each::guarded(input, work) {
        Ok(objects) => return (BenchFile { file: name, error: None, objects }, Status::Done),
        Err(failure) => failure,
    };
    each::print(&failure);
    (BenchFile { file: name, error: Some(failure.message), objects: vec![] }, failure.status)
}

/// Reads an input and makes what is measured: of objects with more than `most` triangles a level,
/// and what it says of them.
fn read(args: &BenchArgs, most: u64, input: &Path) -> Outcome<(Input, Vec<Option<String>>)> {
    let name = input.display().to_string();
    let mut stages = Stages::new(args.import.clock(input));
    let is_file = input.extension().is_some_and(|e| e.eq_ignore_ascii_case("lodc"));
    let simplify_args = SimplifyArgs::by(args.metric.metric);
    let mut asset = if is_file {
        let limits = args.import.options().limits;
        let (file, _) = stages.run("read", || read_lodc(input, limits))?;
        Asset::of_file(file, input, limits)
    } else {
        let scene = stages.run("read", || import::import(input, &args.import.options()))?;
        asset::simplified(input, &args.import, &simplify_args, None, scene, &mut stages)?
    };
    console::warnings(&name, &asset.warnings);
    let progress = Progress::new(&name);
    let objects = std::mem::take(&mut asset.objects).into_iter();
    let reduced = stages.run("level", || {
        objects.map(|o| within(o, most, args.metric.metric)).collect::<Outcome<Vec<_>>>()
    })?;
    let levels: Vec<Option<String>>;
    (asset.objects, levels) = reduced.into_iter().unzip();
    // A file holds errors: they count in its bytes, and streams are cut by them.
    let has_errors = is_file && levels.iter().all(Option::is_none);
    if !args.crowd.crowd && !has_errors {
        asset = asset.measured(simplify_args.max_poses(), &stages.watched(&progress))?;
    }
    let Asset { objects, document, .. } = asset;
    progress.stage("models");
    let models = models_or_all(&args.models);
    let prepared = |object| Prepared::new(object, &models, args.strips.options());
    let prepare = || objects.into_iter().map(prepared).collect::<Result<Vec<_>, _>>();
    let objects = stages.run("models", prepare)?;
    Ok((Input { name, objects, document }, levels))
}

/// An object with more than `most` triangles as its level with so many, simplified anew, and a
/// line about that; any other as it is.
fn within(
    object: LodObject,
    most: u64,
    metric: MetricKind,
) -> Outcome<(LodObject, Option<String>)> {
    let collapses = object.simplified.collapses();
    let all = collapses.parts().triangles;
    if u64::from(all) <= most {
        return Ok((object, None));
    }
    let lod = collapses.lod_for_triangles(most as u32);
    let [mesh] = <[_; 1]>::try_from(reference_meshes(std::slice::from_ref(&object), &[lod])?)
        .expect("one mesh for one object");
    let line = format!(
        "the mesh is large: of its {} triangles, the level with {} is measured",
        grouped(u64::from(all)),
        grouped(mesh.triangles().len() as u64)
    );
    let options = Options { metric, ..Options::DEFAULT };
    let simplified = Arc::new(simplify(&mesh, &options, &|_, _| ()));
    Ok((LodObject { info: object.info, simplified, models: vec![] }, Some(line)))
}

/// Everything measured on one input, for people; `steps` as in [`BenchReport`].
fn text(file: &BenchFile, steps: f64) -> String {
    let object = |ObjectFigures { counts: c, level, figures }: &ObjectFigures| {
        format!(
            "{}: {}\n  {}, {}, {}, {}, {}\n{}{}\n",
            one_line(&file.file),
            one_line(&c.name),
            count(c.referenced_vertices, "vertex"),
            count(c.triangles, "triangle"),
            count(c.submeshes, "submesh"),
            count(c.fakes, "fake"),
            count(c.records, "record"),
            level.as_ref().map(|line| format!("  ({line})\n")).unwrap_or_default(),
            tables(figures, steps)
        )
    };
    file.objects.iter().map(object).collect()
}

/// The charts of all objects of all inputs: file names and SVG texts. Objects after the first of a
/// name have a number.
fn plots(files: &[BenchFile]) -> Vec<(String, String)> {
    let mut plots: Vec<(String, String)> = Vec::new();
    for file in files {
        let stem = Path::new(&file.file).file_stem().unwrap_or_default().to_string_lossy();
        for object in &file.objects {
            let is_taken = |name: &str| plots.iter().any(|(other, _)| other.starts_with(name));
            let numbered = (2..).map(|i| format!("{stem}-{i}"));
            let mut names = std::iter::once(stem.to_string()).chain(numbered);
            let name =
                names.find(|name| !is_taken(&format!("{name}-indices"))).expect("some number");
            let with_name = |(kind, svg): (&str, String)| (format!("{name}-{kind}.svg"), svg);
            let drawn = charts(&object.figures).into_iter().filter(|(_, svg)| !svg.is_empty());
            plots.extend(drawn.map(with_name));
        }
    }
    plots
}

/// Writes charts into a folder.
fn write_plots<N: AsRef<Path>>(folder: &Path, plots: Vec<(N, String)>) -> Outcome<()> {
    let (targets, texts): (Vec<Target>, Vec<String>) =
        plots.into_iter().map(|(name, svg)| (Target::File(folder.join(name)), svg)).unzip();
    output::prepare_targets(&targets, true)?;
    targets.iter().zip(texts).try_for_each(|(to, svg)| output::write(to, svg.into_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_formats::ObjectInfo;

    fn ball() -> LodObject {
        let simplified = simplify(&lodc_fixtures::icosphere(3), &Options::DEFAULT, &|_, _| ());
        let info = ObjectInfo {
            name: "ball".to_owned(),
            submeshes: vec![],
            world_scale: 1.0,
            document_mesh: 0,
            poses: vec![],
        };
        LodObject { info, simplified: Arc::new(simplified), models: vec![] }
    }

    #[test]
    fn of_a_mesh_that_is_too_large_a_level_is_measured_and_it_is_said() {
        let (whole, line) = within(ball(), 1280, MetricKind::Quadric).expect("a mesh");
        assert!(line.is_none() && whole.simplified.mesh().triangles().len() == 1280);
        let (level, line) = within(ball(), 500, MetricKind::Quadric).expect("a mesh");
        assert_eq!(level.simplified.mesh().triangles().len(), 500);
        assert_eq!(level.simplified.collapses().records(), 251);
        let said = "the mesh is large: of its 1,280 triangles, the level with 500 is measured";
        assert_eq!(line.as_deref(), Some(said));
    }
}
