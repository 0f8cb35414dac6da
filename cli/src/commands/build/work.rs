//! Work on the assets of a build: a report for each, whatever happens to it and to the others.

use super::{BuildArgs, ReportFormat, pipeline, summary};
use crate::batch::{self, Asset, Budget, OptionValues};
use crate::commands::each;
use crate::console::{self, error};
use crate::exit::{Failure, Outcome, Status};
use crate::output::{self, Rule, Target};
use crate::progress::{BatchProgress, Progress};
use crate::report::{BuildReport, InputReport, SCHEMA_VERSION, Summary, SummaryReport};
use crate::stages::Stages;
use lodc_formats::lodc;
use rayon::ThreadPool;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// Bytes of memory that a byte of an input file may come to. Text has some 70 bytes for each
/// triangle, a GLB some 30; images only make this more.
const MEMORY_OF_BYTE: u64 = 14;

/// Result of one asset.
struct Done {
    report: InputReport,
    rule: Option<Rule>,
    status: Status,
}

/// Options of assets, parsed once for each set of them.
type Parsed = BTreeMap<OptionValues, Result<BuildArgs, String>>;

/// Builds all assets and reports on them.
///
/// # Errors
/// If a report or the dependency file cannot be written.
pub(super) fn all(args: &BuildArgs, assets: &[Asset], pool: &ThreadPool) -> Outcome<Status> {
    let mut parsed = Parsed::new();
    for asset in assets {
        parsed.entry(asset.options.clone()).or_insert_with(|| {
            let read = batch::arguments::<BuildArgs>("build", &asset.options);
            read.map(|(args, resolved)| BuildArgs { resolved, ..args })
        });
    }
    let needs: Vec<u64> = assets.iter().map(|asset| expected_bytes(&asset.input)).collect();
    let bytes = args.import.limits().memory().unwrap_or(u64::MAX);
    let budget = Budget { workers: pool.current_num_threads(), bytes };
    let bar = BatchProgress::new(assets.len());
    let done = batch::run(&needs, budget, |number| {
        let asset = &assets[number];
        let done = one(asset, &parsed[&asset.options], pool, &bar);
        bar.done(&asset.name);
        if args.report == Some(ReportFormat::Jsonl) {
            console::json_line(&done.report)?;
        }
        Ok(done)
    });
    drop(bar);
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
fn one(
    asset: &Asset,
    parsed: &Result<BuildArgs, String>,
    pool: &ThreadPool,
    bar: &BatchProgress,
) -> Done {
    let start = Instant::now();
    let input = asset.input.as_path();
    let mut report = InputReport { input: input.display().to_string(), ..InputReport::default() };
    let result = each::guarded(input, || {
        let (args, target) = prepared(asset, parsed)?;
        report.output = target.name();
        if let Some(rule) = fresh(args, input, target) {
            report.up_to_date = true;
            return Ok(Some(rule));
        }
        let progress = bar.of_asset(&report.input);
        pool.install(|| build(args, input, target, asset.is_listed(), &progress, &mut report))
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

/// An asset's options and its target, once its result could be written.
fn prepared<'a>(
    asset: &'a Asset,
    parsed: &'a Result<BuildArgs, String>,
) -> Outcome<(&'a BuildArgs, &'a Target)> {
    let target = asset.target.as_ref().map_err(Clone::clone)?;
    let args = parsed.as_ref().map_err(|what| Failure::usage(asset.with_line(what)))?;
    output::prepare(std::slice::from_ref(target), asset.makes_folders)?;
    Ok((args, target))
}

/// The rule of a result that is up to date, if that was asked for and it is.
fn fresh(args: &BuildArgs, input: &Path, target: &Target) -> Option<Rule> {
    let Target::File(path) = target else { return None };
    if !args.if_changed {
        return None;
    }
    // A damaged result, or one that does not say, is made again.
    let made = lodc::made_from(&std::fs::read(path).ok()?).ok()??;
    let inputs = made.unchanged(input, &args.resolved)?;
    Some(Rule { output: path.clone(), inputs })
}

fn build(
    args: &BuildArgs,
    input: &Path,
    target: &Target,
    brief: bool,
    progress: &Progress,
    report: &mut InputReport,
) -> Outcome<Option<Rule>> {
    let mut stages = Stages::default();
    crate::memory::reset_peak();
    let made = pipeline::make(args, input, target, &mut stages, progress, report);
    report.peak_bytes = crate::memory::peak_bytes();
    for warning in &report.warnings {
        console::warning(&report.input, warning);
    }
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
    Ok(Some(Rule { output: path.clone(), inputs: made.files_read }))
}

/// Memory that an asset may need, from the bytes of its file and, for glTF, of its buffers.
fn expected_bytes(input: &Path) -> u64 {
    let size = |path: &Path| path.metadata().map_or(0, |m| m.len());
    let mut bytes = size(input);
    if input.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf")) {
        bytes += size(&input.with_extension("bin"));
    }
    bytes.saturating_mul(MEMORY_OF_BYTE)
}
