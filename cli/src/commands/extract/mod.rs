//! `lodc extract`: one level of detail as a mesh file.

mod one;

use super::each::{self, JobOptions};
use super::export::ExportArgs;
use super::records::Wanted;
use super::runs::JobResult;
use crate::batch::Job;
use crate::console::{self, Loudness, note, wants};
use crate::exit::{Failure, Outcome, Status};
use crate::help::{BECOMES, LEVEL, MORE, OUTPUT};
use crate::kinds::{Choice, parser_with};
use crate::mesh_output::{self, FormatName, OrderName};
use crate::output;
use crate::pose::PoseArgs;
use crate::program::Program;
use crate::results::print_failure;
use crate::selector::{SelectorArgs, bound};
use crate::views::{CriterionName, ViewArgs};
use clap::Args;
use clap::builder::TypedValueParser;
use lodc_lod::ModelKind;
use lodc_report::documents::ExtractReport;
use lodc_report::text::{count, distance, grouped};
use std::path::{Path, PathBuf};

/// Options of `extract`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct ExtractArgs {
    /// Meshes (.glb, .gltf, .obj, .ply, .stl), .lodc files, or folders; - for standard input
    #[arg(value_name = "INPUT", required_unless_present = "manifest")]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    selector: SelectorArgs,
    /// Error of at most E (or E%), whatever else is asked for
    #[arg(long, value_name = "E", value_parser = bound, conflicts_with = "criterion",
          help_heading = LEVEL, hide_short_help = true)]
    max_error: Option<lodc_select::Target>,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    pose: PoseArgs,
    #[command(flatten)]
    export: ExportArgs,
    /// Keep every vertex where the input has it
    ///
    /// By default vertices move to where they fit the input best, but no object's so far that it
    /// looks worse or its largest distance grows by more than 5 %; none beyond an --error, --rms,
    /// --pixels or --max-error that is asked for. Errors are measured on the result. A level that
    /// is asked for as it is stored (--lod, --model, --criterion) keeps its vertices.
    #[arg(long, help_heading = BECOMES, display_order = 0)]
    no_refit: bool,
    /// Move vertices with --lod and --model, too
    #[arg(long, conflicts_with = "criterion", overrides_with = "no_refit", help_heading = BECOMES,
          display_order = 0, hide_short_help = true)]
    refit: bool,
    /// Order of triangles and vertices [default: cache; size with compression]
    #[arg(long, value_enum, help_heading = BECOMES, display_order = 1,
          hide_short_help = true)]
    order: Option<OrderName>,
    /// Structure to replay [default: the first in the file]
    ///
    /// All give the same triangles.
    #[arg(long, value_parser = replays(), conflicts_with = "criterion", help_heading = BECOMES,
          display_order = 2, hide_short_help = true)]
    model: Option<Choice<ModelKind>>,
    /// File (.glb, .vrm, .gltf, .obj, .ply, .stl), or folder; - for standard output
    ///
    /// For several inputs always a folder. A folder that is there, or a name with / at its end,
    /// means a file inside it. There club.obj becomes club.obj.glb; results of a folder keep its
    /// structure.
    #[arg(short, long, value_name = "OUT", help_heading = OUTPUT, display_order = 0)]
    output: PathBuf,
    /// Format, if the name of OUT does not say [default: glb]
    #[arg(long, value_enum, help_heading = OUTPUT, display_order = 0)]
    format: Option<FormatName>,
    /// Every option that can change the result, as text.
    #[arg(skip)]
    options_text: String,
}

const EXAMPLES: &str = "\
Examples:
  lodc extract chair.glb --ratio 25% -o chair.quarter.glb
  lodc extract chair.lodc --error 0.5% --textures keep -o chair.obj
  lodc extract models --triangles 10k --compress meshopt -o levels";

/// The names of all that may be replayed.
fn replays() -> impl TypedValueParser<Value = Choice<ModelKind>> {
    parser_with("reference", "No structure: the naive answer that every model is judged by")
}

impl ExtractArgs {
    /// Returns whether there is one input, in a small file.
    pub(crate) fn is_small(&self) -> bool {
        self.export.is_small(&self.inputs)
    }

    /// Returns whether vertices are moved to where they fit the input best.
    fn refits(&self) -> bool {
        let is_as_stored = self.model.is_some()
            || matches!(self.selector.target(), Some(lodc_select::Target::Lod(_)));
        self.refit || !self.no_refit && !is_as_stored
    }

    /// Returns the criterion of a view, if that is what is wanted.
    ///
    /// # Errors
    /// If options do not fit together.
    fn criterion(&self) -> Outcome<Option<CriterionName>> {
        let criterion = self.view.check(&self.selector)?;
        if criterion.is_some() {
            return Ok(criterion);
        }
        let of_views = [
            ("--eye", self.view.at.eye.is_some()),
            ("--target", self.view.at.target.is_some()),
            ("--pose", self.pose.is_given()),
        ];
        if let Some((option, _)) = of_views.into_iter().find(|(_, is_given)| *is_given) {
            return Err(Failure::usage(format!("{option} needs --criterion")));
        }
        if self.selector.target().is_none() {
            return Err(Failure::usage(
                "a level is required: one of --lod, --ratio, --triangles, --error, --rms and \
                 --pixels, or a --criterion",
            ));
        }
        Ok(None)
    }
}

/// Extracts a level of each input, several at a time within the memory that is allowed; with
/// `--if-changed` leaves a result that is up to date. Prints a line for each, then the report.
pub(crate) fn run(args: &ExtractArgs, program: &Program) -> Outcome<Status> {
    let (jobs, format) = print_failure(args.export.run.reports(), jobs(args, program))?;
    let with_text = |args, options_text| ExtractArgs { options_text, ..args };
    let options = JobOptions::new(program, "extract", &jobs, with_text);
    let need = |job: &Job| options.of(job).ok()?.export.need(&job.input);
    let done = each::all(&jobs, args.export.import.limits().budget(), need, |_, job, bar| {
        args.export.run.one(job, || {
            let (args, target) = options.ready(job)?;
            args.export.check(format, target)?;
            let beside = args.export.import.assets(&job.input, None);
            let (run, text) = (&args.export.run, &args.options_text);
            let wanted = Wanted::new(run, &job.input, target, &beside, text);
            if let Some(left) = wanted.and_then(Wanted::if_up_to_date) {
                return Ok(left);
            }
            let bar = bar.of_asset(&job.name);
            let made = one::extract(args, &job.input, target, wanted, format, &bar)?;
            say(&job.input, &made.report);
            if !job.is_listed() && !args.export.run.reports() && wants(Loudness::Normal) {
                made.tip.into_iter().for_each(note);
            }
            Ok(JobResult::done(made.report, made.rules))
        })
    });
    args.export.finish("extract", (&args.inputs, &args.output, format), &jobs, done)
}

/// The assets and the format of their results.
fn jobs(args: &ExtractArgs, program: &Program) -> Outcome<(Vec<Job>, FormatName)> {
    let folder = args.export.batch.takes_many(&args.inputs) || output::is_folder(&args.output);
    let format = mesh_output::format(&args.output, args.format, folder)?;
    Ok((args.export.jobs((program, "extract"), &args.inputs, &args.output, format)?, format))
}

/// Prints warnings and what was extracted.
fn say(input: &Path, report: &ExtractReport) {
    console::warnings(&input.display().to_string(), &report.warnings);
    if wants(Loudness::Normal) {
        note(&sentence(report));
    }
}

fn sentence(report: &ExtractReport) -> String {
    if let Some(criterion) = report.criterion {
        return format!(
            "{}: {criterion}, {} ({:.1} %), {}",
            named(report),
            count(report.triangles, "triangle"),
            report.kept_share * 100.0,
            count(report.vertices, "vertex")
        );
    }
    let lod = match report.lod {
        Some(lod) => format!("LOD {}", grouped(u64::from(lod))),
        None => format!("{} objects", report.objects.len()),
    };
    format!(
        "{}: {lod}, {}, {}, error {}{}",
        named(report),
        count(report.triangles, "triangle"),
        count(report.vertices, "vertex"),
        distance(report.error.unwrap_or(f64::INFINITY)),
        if report.refitted { " (refitted)" } else { "" }
    )
}

fn named(report: &ExtractReport) -> &str {
    if report.output == "-" { "standard output" } else { &report.output }
}
