//! `build --estimate`: what a build needs, told by the headers of its inputs. Nothing is built.

use super::{BuildArgs, ReportFormat, pipeline};
use crate::batch::{Asset, Budget};
use crate::commands::each::{self, AssetOptions};
use crate::console;
use crate::exit::{Outcome, Status};
use crate::output;
use crate::program::Program;
use lodc::build::Size;
use lodc_formats::import;
use lodc_report::SCHEMA_VERSION;
use lodc_report::documents::{EstimateReport, InputEstimate};
use lodc_report::text::{count, size};

/// Bytes that the program takes whatever it builds, with one thread: itself, its allocator's
/// reserve, stacks (measured: 26 MB).
const PROGRAM: u64 = 48 << 20;
/// Bytes that a byte of an input comes to: itself, what it decodes to, the document that the result
/// holds, and the result.
const OF_BYTE: u64 = 4;

/// Estimates all assets, and says what was found.
///
/// # Errors
/// If that cannot be said.
pub(super) fn all(args: &BuildArgs, program: &Program, assets: &[Asset]) -> Outcome<Status> {
    let options = AssetOptions::new(program, "build", assets, |args, _| args);
    let budget = Budget { workers: rayon::current_num_threads(), bytes: u64::MAX };
    let inputs = each::all(assets, budget, |_, asset, _| one(asset, &options));
    let worst = inputs.iter().map(|(status, _)| *status).max().unwrap_or_default();
    for (_, input) in &inputs {
        match args.report {
            Some(ReportFormat::Json) => {}
            Some(ReportFormat::Jsonl) => console::json_line(input)?,
            None if input.error.is_none() => console::result(&text(input))?,
            None => {}
        }
    }
    if args.report == Some(ReportFormat::Json) {
        console::json(&EstimateReport {
            schema_version: SCHEMA_VERSION,
            tool_version: env!("CARGO_PKG_VERSION"),
            inputs: inputs.into_iter().map(|(_, input)| input).collect(),
        })?;
    }
    Ok(worst)
}

/// One asset.
fn one(asset: &Asset, options: &AssetOptions<BuildArgs>) -> (Status, InputEstimate) {
    let name = asset.input.display().to_string();
    let found = each::guarded(&asset.input, || {
        let args = options.of(asset)?;
        if output::is_stream(&asset.input) {
            let what = "standard input cannot be estimated: it can be read once only";
            return Err(crate::exit::Failure::usage(what));
        }
        let counted = import::count(&asset.input, &args.import.options())?;
        let of = Size { triangles: counted.triangles, vertices: counted.vertices };
        let metric = args.simplify_options().metric;
        let needs = pipeline::needs(of, [metric].into_iter(), &args.models.kinds()?);
        let most = needs.iter().map(|need| need.bytes).max().unwrap_or(0);
        let memory =
            most.saturating_add(counted.bytes.saturating_mul(OF_BYTE)).saturating_add(PROGRAM);
        Ok((counted, memory))
    });
    match found {
        Ok((counted, memory)) => (
            Status::Done,
            InputEstimate {
                input: name,
                status: Status::Done.code(),
                triangles: Some(counted.triangles),
                vertices: Some(counted.vertices),
                bytes: Some(counted.bytes),
                memory: Some(memory),
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
    let of = |n: Option<u64>| n.unwrap_or(0);
    format!(
        "{}: {}, {}, {} of memory",
        input.input,
        count(of(input.triangles), "triangle"),
        count(of(input.vertices), "vertex"),
        size(of(input.memory))
    )
}
