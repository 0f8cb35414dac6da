//! Standard streams of a run, and its dependency file: each holds one thing.

use super::Asset;
use crate::exit::{Failure, Outcome};
use crate::output::{self, Target};
use std::path::Path;

/// Checks that standard input is read once, that standard output has one thing to hold, and that
/// the dependency file has a place of its own. `document` says that a report takes standard output.
///
/// # Errors
/// If not, or the dependency file could not be written.
pub(crate) fn check_streams(
    assets: &[Asset],
    document: bool,
    depfile: Option<&Path>,
) -> Outcome<()> {
    if assets.iter().filter(|asset| output::is_stream(&asset.input)).count() > 1 {
        return Err(Failure::usage("standard input can be read once only"));
    }
    let targets = || assets.iter().filter_map(|asset| asset.target.as_ref().ok());
    let to_stdout = targets().any(|target| *target == Target::Stdout);
    if to_stdout && document {
        return Err(Failure::usage("the report and the output do not fit one standard output"));
    }
    let Some(depfile) = depfile else { return Ok(()) };
    if to_stdout || output::is_stream(depfile) {
        return Err(Failure::usage("a dependency file needs files, not standard output"));
    }
    let inputs = assets.iter().map(|asset| asset.input.display().to_string());
    if targets().map(Target::name).chain(inputs).any(|o| o == depfile.display().to_string()) {
        return Err(Failure::usage(format!(
            "{}: named both as dependency file and as mesh",
            depfile.display()
        )));
    }
    output::prepare(&[Target::File(depfile.to_owned())], false)
}
