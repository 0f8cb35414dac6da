//! Work on the assets of a build: a report for each, whatever happens to it and to the others.

use super::{BuildArgs, ReportFormat, pipeline, summary};
use crate::batch::{Asset, Budget};
use crate::commands::each::{self, AssetOptions};
use crate::console::{self, error};
use crate::exit::{Outcome, Status};
use crate::output::{self, Rule, Target};
use crate::program::Program;
use crate::progress::{BatchProgress, Progress};
use crate::stages::Stages;
use lodc_formats::lodc;
use lodc_report::documents::{BuildReport, InputReport, Summary, SummaryReport};
use lodc_report::{SCHEMA_VERSION, Suite};
use std::path::Path;
use std::time::Instant;

/// Result of one asset.
struct Done {
    report: InputReport,
    rule: Option<Rule>,
    status: Status,
}

/// Builds all assets and reports on them.
///
/// # Errors
/// If a report or the dependency file cannot be written.
pub(super) fn all(args: &BuildArgs, program: &Program, assets: &[Asset]) -> Outcome<Status> {
    let resolving = |args, resolved| BuildArgs { resolved, ..args };
    let options = AssetOptions::new(program, "build", assets, resolving);
    let bytes = args.import.limits().memory().unwrap_or(u64::MAX);
    let budget = Budget { workers: rayon::current_num_threads(), bytes };
    let done = each::all(assets, budget, |asset, bar| {
        let done = one(asset, &options, bar);
        if args.report == Some(ReportFormat::Jsonl) {
            console::json_line(&done.report)?;
        }
        Ok(done)
    });
    let done: Vec<Done> = done.into_iter().collect::<Outcome<_>>()?;
    report(args, done)
}

fn report(args: &BuildArgs, done: Vec<Done>) -> Outcome<Status> {
    let mut summary = Summary::default();
    for one in &done {
        match (one.status, one.report.up_to_date) {
            (Status::Done, true) => summary.up_to_date += 1,
            (Status::Done, false) => summary.built += 1,
            _ => summary.failed += 1,
        }
    }
    let mut worst = done.iter().map(|one| one.status).max().unwrap_or_default();
    if let Some(depfile) = &args.depfile {
        let rules: Vec<Rule> = done.iter().filter_map(|one| one.rule.clone()).collect();
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
    args.ci.publish("lodc build", &suites)?;
    match args.report {
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

/// One asset from bytes to bytes.
fn one(asset: &Asset, options: &AssetOptions<BuildArgs>, bar: &BatchProgress) -> Done {
    let start = Instant::now();
    let input = asset.input.as_path();
    let mut report = InputReport { input: input.display().to_string(), ..InputReport::default() };
    let result = each::guarded(input, || {
        let (args, target) = options.ready(asset)?;
        report.output = target.name();
        if let Some((rule, warnings)) = fresh(args, input, target) {
            (report.up_to_date, report.warnings) = (true, warnings);
            warn(&report);
            return Ok(Some(rule));
        }
        let progress = bar.of_asset(&report.input);
        build(args, input, target, asset.is_listed(), &progress, &mut report)
    });
    report.seconds = start.elapsed().as_secs_f64();
    let (status, rule) = match result {
        Ok(rule) => (Status::Done, rule),
        Err(failure) => {
            each::print(&failure);
            report.error = Some(failure.message);
            (failure.status, None)
        }
    };
    report.status = status.code();
    Done { report, rule, status }
}

/// The rule of a result that is up to date, with the warnings of the run that made it, if that was
/// asked for and it is.
fn fresh(args: &BuildArgs, input: &Path, target: &Target) -> Option<(Rule, Vec<String>)> {
    let Target::File(path) = target else { return None };
    if !args.if_changed {
        return None;
    }
    // A damaged result, or one that does not say, is made again.
    let made = lodc::made_from(&std::fs::read(path).ok()?).ok()??;
    let files = made.unchanged(input, &args.import.assets(input, None), &args.resolved)?;
    Some((Rule::new(path, &files), made.warnings))
}

fn build(
    args: &BuildArgs,
    input: &Path,
    target: &Target,
    brief: bool,
    progress: &Progress,
    report: &mut InputReport,
) -> Outcome<Option<Rule>> {
    let mut stages = Stages::new(args.import.clock(input));
    crate::memory::reset_peak();
    let made = pipeline::make(args, input, target, &mut stages, progress, report);
    report.peak_bytes = crate::memory::peak_bytes();
    warn(report);
    let seconds = stages.seconds();
    report.stages = stages.into_reports();
    let made = made?;
    progress.clear();
    if brief {
        summary::print_line(&made, target, seconds);
    } else {
        summary::print(&made, target, seconds);
    }
    let Target::File(path) = target else { return Ok(None) };
    Ok(Some(Rule::new(path, &made.files)))
}

fn warn(report: &InputReport) {
    report.warnings.iter().for_each(|warning| console::warning(&report.input, warning));
}
