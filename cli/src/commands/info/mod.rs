//! `lodc info`: what is inside files and streams.

mod file;
mod stream;

use super::each;
use crate::batch;
use crate::clock;
use crate::console;
use crate::exit::{Failure, Outcome, Status};
use crate::help::{MANY_ASSETS, MEASURED, MORE, OUTPUT};
use crate::limits::LimitArgs;
use crate::output::is_standard_stream;
use crate::results::{self, FailureReport, ResultReport};
use clap::Args;
use lodc_formats::{Assets, lods};
use lodc_report::documents::{InfoReport, StreamInfoReport};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Options of `info`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct InfoArgs {
    /// .lodc files, .lods streams (or prefixes), or folders of both; - for standard input
    #[arg(value_name = "INPUT", required = true)]
    inputs: Vec<PathBuf>,
    /// Count the bits of other structures, too, for comparison
    ///
    /// They are made for this: it takes a while on large meshes.
    #[arg(long, help_heading = MEASURED)]
    baselines: bool,
    /// Print one JSON document on standard output
    #[arg(long, help_heading = OUTPUT)]
    json: bool,
    /// In folders, only files whose path below the folder matches
    ///
    /// * does not match a slash, ** does. May be given several times.
    #[arg(long, value_name = "GLOB", help_heading = MANY_ASSETS, hide_short_help = true)]
    include: Vec<String>,
    /// In folders, no files whose path below the folder matches
    ///
    /// * does not match a slash, ** does. May be given several times.
    #[arg(long, value_name = "GLOB", help_heading = MANY_ASSETS, hide_short_help = true)]
    exclude: Vec<String>,
    #[command(flatten)]
    limits: LimitArgs,
}

const EXAMPLES: &str = "\
Examples:
  lodc info chair.lodc
  lodc info levels --json";

/// The document about one input.
#[derive(Debug, Serialize)]
struct InputInfo {
    /// Its path; only where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    input: Option<String>,
    #[serde(flatten)]
    content: Content,
}

/// What is inside an input.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Content {
    File(InfoReport),
    Stream(StreamInfoReport),
}

pub(crate) fn run(args: &InfoArgs) -> Outcome<Status> {
    if args.inputs.iter().filter(|input| is_standard_stream(input)).count() > 1 {
        return Err(Failure::usage("standard input can be read once only"));
    }
    let inputs =
        batch::expand_folders(&args.inputs, &["lodc", "lods"], &args.include, &args.exclude)?;
    let several = args.inputs.len() > 1 || args.inputs.iter().any(|input| input.is_dir());
    clock::expect_several(several);
    let (mut worst, mut results) = (Status::Done, Vec::new());
    for (number, input) in inputs.iter().enumerate() {
        let failure = match each::guarded(input, || content(args, input)) {
            Ok((content, failure)) => {
                if !args.json {
                    print(input, &content, number > 0)?;
                }
                let input = several.then(|| input.display().to_string());
                results.push(ResultReport::Done(InputInfo { input, content }));
                failure
            }
            Err(failure) => {
                results.push(ResultReport::Failed(FailureReport::of(input, &failure)));
                Some(failure)
            }
        };
        if let Some(failure) = failure {
            each::print(&failure);
            worst = worst.max(failure.status);
        }
    }
    if args.json {
        results::print(several, worst, results)?;
    }
    Ok(worst)
}

/// Returns what is inside an input, and for a stream the failure of the first part that cannot be
/// used.
fn content(args: &InfoArgs, input: &Path) -> Outcome<(Content, Option<Failure>)> {
    let (limits, clock) = (args.limits.limits(), args.limits.clock(input));
    let mut assets = Assets::new(input, &[], limits);
    let (name, bytes) = (assets.main_name(), assets.read_main()?);
    clock.check();
    if lods::is_lods(&bytes) {
        let (report, failure) = stream::report(&name, &bytes, limits)?;
        clock.check();
        return Ok((Content::Stream(report), failure));
    }
    let report = file::report(&name, &bytes, args.baselines, args.json.then_some(&limits))?;
    clock.check();
    Ok((Content::File(report), None))
}

/// Prints what is inside an input; `follows` says that a blank line comes before it.
fn print(input: &Path, content: &Content, follows: bool) -> Outcome<()> {
    let name = input.display().to_string();
    let text = match content {
        Content::File(report) => file::text(&name, report),
        Content::Stream(report) => stream::text(&name, report),
    };
    console::result(&format!("{}{}", if follows { "\n" } else { "" }, text.trim_end()))
}
