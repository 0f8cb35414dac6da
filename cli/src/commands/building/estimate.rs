//! `lodc build --estimate`: the memory that a build is likely to need, from the counts in its
//! inputs' headers. Nothing is built.

use super::{BuildArgs, pipeline};
use crate::batch::{Budget, Job};
use crate::commands::each::{self, JobOptions};
use crate::commands::estimate::estimate;
use crate::commands::runs::ReportFormat;
use crate::console;
use crate::exit::{Outcome, Status};
use crate::program::Program;
use lodc_formats::import;
use lodc_report::SCHEMA_VERSION;
use lodc_report::documents::{EstimateReport, InputEstimate};
use lodc_report::text::{count, size};
use lodc_simplify::MetricKind;

/// Bytes of memory that the program takes whatever it builds, with one thread: its code, the
/// allocator's reserve, stacks. Measured: 26 MB; the rest is margin.
const PROGRAM_BYTES: u64 = 48 << 20;

/// Counts what an asset holds, and estimates the bytes of memory that it needs beside the program's
/// own.
///
/// # Errors
/// As [`estimate`], or if its options are wrong.
pub(super) fn memory(
    job: &Job,
    options: &JobOptions<BuildArgs>,
) -> Outcome<(import::Counted, u64)> {
    let args = options.of(job)?;
    let (metric, kinds) = (args.simplify_options().metric, args.models.kinds()?);
    estimate(&job.input, &args.import, |size| pipeline::needs(size, [metric].into_iter(), &kinds))
}

/// Processor seconds that a build is likely to take. Per triangle of scans and CAD, with errors and
/// models: 16 to 60 microseconds by `quadric`, ten times as long by `hybrid`; pictures take longer.
fn seconds(triangles: u64, metric: MetricKind) -> f64 {
    let microseconds = match metric {
        MetricKind::Quadric => 30.0,
        MetricKind::Hybrid => 300.0,
        MetricKind::Viewpoint | MetricKind::Divergence => 2000.0,
    };
    0.01 + triangles as f64 * microseconds * 1e-6
}

/// Estimates all assets and prints what was found.
///
/// # Errors
/// If standard output cannot be written.
pub(super) fn estimate_all(args: &BuildArgs, program: &Program, jobs: &[Job]) -> Outcome<Status> {
    let options = JobOptions::new(program, "build", jobs, |args, _| args);
    // Nothing is built, so no asset has to wait for memory.
    let budget = Budget { workers: rayon::current_num_threads(), bytes: u64::MAX };
    let inputs = each::all(jobs, budget, |_| None, |_, job, _| estimate_asset(job, &options));
    let worst = inputs.iter().map(|(status, _)| *status).max().unwrap_or_default();
    for (_, input) in &inputs {
        match args.run.format() {
            Some(ReportFormat::Json) => {}
            Some(ReportFormat::Jsonl) => console::json_line(input)?,
            None if input.error.is_none() => console::result(&text(input))?,
            None => {}
        }
    }
    if args.run.format() == Some(ReportFormat::Json) {
        console::json(&EstimateReport {
            schema_version: SCHEMA_VERSION,
            tool_version: env!("CARGO_PKG_VERSION"),
            inputs: inputs.into_iter().map(|(_, input)| input).collect(),
        })?;
    }
    Ok(worst)
}

/// The status and the estimate of one asset. Prints its failure.
fn estimate_asset(job: &Job, options: &JobOptions<BuildArgs>) -> (Status, InputEstimate) {
    let name = job.input.display().to_string();
    let estimate = each::guarded(&job.input, || {
        let (counted, memory) = memory(job, options)?;
        let seconds = seconds(counted.triangles, options.of(job)?.simplify_options().metric);
        Ok((counted, memory.saturating_add(PROGRAM_BYTES), seconds))
    });
    match estimate {
        Ok((counted, memory, seconds)) => (
            Status::Done,
            InputEstimate {
                input: name,
                status: Status::Done.code(),
                triangles: Some(counted.triangles),
                vertices: Some(counted.vertices),
                bytes: Some(counted.bytes),
                memory: Some(memory),
                seconds: Some(seconds),
                error: None,
            },
        ),
        Err(failure) => {
            each::print(&failure);
            let status = failure.status;
            let error = Some(failure.message);
            (
                status,
                InputEstimate { input: name, status: status.code(), error, ..Default::default() },
            )
        }
    }
}

fn text(input: &InputEstimate) -> String {
    let known = |number: Option<u64>| number.unwrap_or(0);
    format!(
        "{}: {}, {}, {} of memory",
        input.input,
        count(known(input.triangles), "triangle"),
        count(known(input.vertices), "vertex"),
        size(known(input.memory))
    )
}
