//! The standard streams of a run and its dependency file are each used for one thing only.

use crate::jobs::error::JobError;
use crate::jobs::run::Job;
use crate::jobs::target::{Target, is_standard_stream, prepare_targets};
use std::path::Path;

/// Checks that standard input is read by one asset at most, that standard output gets either a
/// result or the JSON report, and that the dependency file is none of the inputs and results.
///
/// # Errors
/// If not, or if the dependency file could not be written.
pub(crate) fn check_standard_streams(
    jobs: &[Job],
    report_to_stdout: bool,
    depfile: Option<&Path>,
) -> Result<(), JobError> {
    if jobs.iter().filter(|job| is_standard_stream(&job.input)).count() > 1 {
        return Err(JobError::Usage("standard input can be read once only".to_owned()));
    }
    let targets = || jobs.iter().filter_map(|job| job.target.as_ref().ok());
    let result_to_stdout = targets().any(|target| *target == Target::Stdout);
    if result_to_stdout && report_to_stdout {
        return Err(JobError::Usage(
            "the report and the output cannot both go to standard output".to_owned(),
        ));
    }
    let Some(depfile) = depfile else { return Ok(()) };
    if result_to_stdout || is_standard_stream(depfile) {
        return Err(JobError::Usage(
            "a dependency file needs files, not standard output".to_owned(),
        ));
    }
    let inputs = jobs.iter().map(|job| job.input.display().to_string());
    if targets().map(Target::name).chain(inputs).any(|path| path == depfile.display().to_string()) {
        return Err(JobError::Usage(format!(
            "{}: named both as dependency file and as mesh",
            depfile.display()
        )));
    }
    prepare_targets(&[Target::File(depfile.to_owned())], false)
}
