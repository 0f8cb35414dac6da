//! Builds several assets: each gets a report of its own, and one that fails or panics does not stop
//! the others.

use super::pipeline::{self, OneBuild};
use super::{BuildArgs, estimate, summary};
use crate::batch::{self, CommandPaths, Job, MESH_EXTENSIONS};
use crate::commands::each::{self, JobOptions};
use crate::commands::prune::Written;
use crate::commands::runs::ReportFormat;
use crate::console::{self, error};
use crate::exit::{Outcome, Status};
use crate::output::{self, DependencyRule, Results, Target};
use crate::program::Program;
use crate::progress::BatchProgress;
use crate::stages::Stages;
use lodc_formats::{OutputFile, lodc};
use lodc_report::documents::{BuildReport, InputReport, Summary, SummaryReport};
use lodc_report::{SCHEMA_VERSION, Suite};
use std::path::Path;
use std::sync::OnceLock;
use std::time::Instant;

/// The result of one asset.
struct FinishedBuild {
    report: InputReport,
    /// Its rule in the dependency file.
    rule: Option<DependencyRule>,
    status: Status,
    /// A line about it, to be printed once its file is written.
    line: Option<String>,
}

/// Builds all assets and reports on them.
///
/// # Errors
/// If an argument is wrong, or a report or the dependency file cannot be written.
pub(crate) fn run(args: &BuildArgs, program: &Program) -> Outcome<Status> {
    // A wrong `--models` is refused before anything is read.
    args.models.kinds()?;
    let paths = CommandPaths {
        inputs: &args.inputs,
        output: args.output.as_deref(),
        input_extensions: &MESH_EXTENSIONS,
        output_extension: "lodc",
        allowed_folders: args.import.allowed(),
    };
    let mut jobs = batch::jobs(paths, &args.batch)?;
    args.configuration.apply(program, "build", &mut jobs)?;
    if args.estimate {
        return estimate::estimate_all(args, program, &jobs);
    }
    args.run.check(&jobs)?;

    let with_text = |args, options_text| BuildArgs { options_text, ..args };
    let options = JobOptions::new(program, "build", &jobs, with_text);
    let budget = args.import.limits().budget();
    let need = |job: &Job| estimate::memory(job, &options).ok().map(|(_, bytes)| bytes);
    let results: Vec<OnceLock<Outcome<FinishedBuild>>> =
        jobs.iter().map(|_| OnceLock::new()).collect();
    let on_written = |(number, done): (usize, FinishedBuild), written| {
        // Each asset has one result.
        let _ = results[number].set(report_written(args, done, written));
    };
    // Workers build and hand files to the writer, which puts many of them into place at a time and
    // then calls `on_written` for each.
    Results::gather(on_written, |writer| {
        each::all(&jobs, budget, need, |number, job, bar| {
            let (done, file) = build_asset(job, &options, bar);
            writer.add(file, (number, done));
        });
    });
    let done =
        results.into_iter().map(|done| done.into_inner().expect("each asset has had its turn"));
    let status = finish(args, done.collect::<Outcome<_>>()?)?;
    args.prune.sweep(paths, (&args.batch, &jobs), Written::ByBuild)?;
    Ok(status)
}

/// Takes down and prints whether an asset's file was written.
fn report_written(
    args: &BuildArgs,
    mut done: FinishedBuild,
    written: Outcome<()>,
) -> Outcome<FinishedBuild> {
    match written {
        Ok(()) => done.line.iter().for_each(|line| console::note(line)),
        Err(failure) => {
            each::print(&failure);
            done.status = failure.status;
            done.rule = None;
            done.report.status = failure.status.code();
            done.report.error = Some(failure.message);
        }
    }
    if args.run.format() == Some(ReportFormat::Jsonl) {
        console::json_line(&done.report)?;
    }
    Ok(done)
}

/// Writes the dependency file and all reports. Returns the highest status.
fn finish(args: &BuildArgs, done: Vec<FinishedBuild>) -> Outcome<Status> {
    let mut summary = Summary::default();
    for one in &done {
        match (one.status, one.report.up_to_date) {
            (Status::Done, true) => summary.up_to_date += 1,
            (Status::Done, false) => summary.built += 1,
            _ => summary.failed += 1,
        }
    }
    let mut worst = done.iter().map(|one| one.status).max().unwrap_or_default();
    if let Some(depfile) = &args.run.depfile {
        let rules: Vec<DependencyRule> = done.iter().filter_map(|one| one.rule.clone()).collect();
        if let Err(failure) = output::write_depfile(depfile, &rules) {
            error(&failure);
            worst = worst.max(failure.status);
        }
    }
    if done.len() > 1 {
        let Summary { built, up_to_date, failed } = summary;
        console::note(&format!("{built} built, {up_to_date} up to date, {failed} failed"));
    }
    let suites: Vec<Suite> = done.iter().map(|one| one.report.suite()).collect();
    args.run.ci.publish("lodc build", &suites)?;
    match args.run.format() {
        Some(ReportFormat::Json) => console::json(&BuildReport {
            schema_version: SCHEMA_VERSION,
            tool_version: env!("CARGO_PKG_VERSION"),
            inputs: done.into_iter().map(|one| one.report).collect(),
            summary,
        })?,
        Some(ReportFormat::Jsonl) => console::json_line(&SummaryReport { summary })?,
        None => {}
    }
    Ok(worst)
}

/// Builds one asset; its file is written later.
fn build_asset(
    job: &Job,
    options: &JobOptions<BuildArgs>,
    bar: &BatchProgress,
) -> (FinishedBuild, Option<OutputFile>) {
    let start = Instant::now();
    let input = job.input.as_path();
    let mut report = InputReport { input: input.display().to_string(), ..InputReport::default() };
    let result = each::guarded(input, || {
        let (args, target) = options.ready(job)?;
        report.output = target.name();
        if let Some((rule, warnings)) = up_to_date(args, input, target) {
            (report.up_to_date, report.warnings) = (true, warnings);
            warn(&report);
            return Ok(Built { rule: Some(rule), ..Built::default() });
        }
        let progress = bar.of_asset(&report.input);
        let mut stages = Stages::new(args.import.clock(input));
        crate::memory::reset_peak();
        let one = OneBuild { args, input, target, is_listed: job.is_listed() };
        let made = pipeline::make(one, &mut stages, &progress, &mut report);
        report.peak_bytes = crate::memory::peak_bytes();
        warn(&report);
        let seconds = stages.seconds();
        report.stages = stages.into_reports();
        let made = made?;
        progress.clear();
        let line = job.is_listed().then(|| summary::line(&made, target, seconds));
        if line.is_none() {
            summary::print(&made, target, seconds);
        }
        let rule = target.file().map(|path| DependencyRule::new(path, &made.files));
        Ok(Built { rule, line, unwritten: made.unwritten })
    });
    report.seconds = start.elapsed().as_secs_f64();
    let (status, built) = match result {
        Ok(built) => (Status::Done, built),
        Err(failure) => {
            each::print(&failure);
            report.error = Some(failure.message);
            (failure.status, Built::default())
        }
    };
    report.status = status.code();
    let Built { rule, line, unwritten } = built;
    let rule = rule.map(|rule| rule.with_options_of(job));
    (FinishedBuild { report, rule, status, line }, unwritten)
}

/// What is still to be done for an asset that was built or is up to date.
#[derive(Default)]
struct Built {
    rule: Option<DependencyRule>,
    line: Option<String>,
    unwritten: Option<OutputFile>,
}

/// With `--if-changed`, the rule of a result that is up to date, and the warnings of the run that
/// made it; else none.
fn up_to_date(
    args: &BuildArgs,
    input: &Path,
    target: &Target,
) -> Option<(DependencyRule, Vec<String>)> {
    let Target::File(path) = target else { return None };
    if !args.run.if_changed {
        return None;
    }
    // A damaged result, or one without a record of its inputs, is made again.
    let made = lodc::made_from(&std::fs::read(path).ok()?).ok()??;
    let files = made.unchanged(input, &args.import.assets(input, None), &args.options_text)?;
    Some((DependencyRule::new(path, &files), made.warnings))
}

fn warn(report: &InputReport) {
    console::warnings(&report.input, &report.warnings);
}
