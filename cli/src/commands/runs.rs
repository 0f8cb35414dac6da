//! What a run over many assets tells, and which results it leaves alone: the same for every command
//! that takes folders.

use super::ci::CiArgs;
use super::each;
use crate::batch::{self, Job};
use crate::console;
use crate::exit::{Outcome, Status};
use crate::help::OUTPUT;
use crate::output::{self, DependencyRule};
use crate::results::{self, FailureReport, ResultReport};
use clap::{Args, ValueEnum};
use lodc_report::documents::{Summary, SummaryReport};
use lodc_report::{Case, Suite, Verdict};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Options of a run.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = OUTPUT)]
pub(crate) struct RunArgs {
    /// Leave results alone that are up to date
    ///
    /// The input, the files it names, options and version are those that the result was made from.
    /// Contents are compared, never times.
    #[arg(long)]
    pub(crate) if_changed: bool,
    /// Print one JSON document on standard output
    ///
    /// Also when inputs failed.
    #[arg(long)]
    json: bool,
    /// Print such a document (json), or one in each line as results come (jsonl)
    #[arg(
        long,
        value_enum,
        value_name = "FORMAT",
        conflicts_with = "json",
        hide_short_help = true
    )]
    report: Option<ReportFormat>,
    /// Write a Make/Ninja dependency file that names every file read
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub(crate) depfile: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) ci: CiArgs,
}

/// Formats of the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ReportFormat {
    Json,
    Jsonl,
}

/// The result of one asset.
pub(crate) struct JobResult<R> {
    /// Its part of the JSON document.
    pub(crate) report: ResultReport<R>,
    /// Its rules for a dependency file: which files it read and wrote.
    pub(crate) rules: Vec<DependencyRule>,
}

impl<R> JobResult<R> {
    /// A result that was made now.
    pub(crate) fn done(report: R, rules: Vec<DependencyRule>) -> Self {
        Self { report: ResultReport::Done(report), rules }
    }
}

/// What became of an asset.
pub(crate) struct Finished<R> {
    status: Status,
    result: JobResult<R>,
}

impl RunArgs {
    /// The report that is wanted.
    pub(crate) fn format(&self) -> Option<ReportFormat> {
        if self.json { Some(ReportFormat::Json) } else { self.report }
    }

    /// Returns whether standard output is for a report.
    pub(crate) fn reports(&self) -> bool {
        self.format().is_some()
    }

    /// Checks that the files of reports can be written, and that each standard stream has one use.
    ///
    /// # Errors
    /// If not.
    pub(crate) fn check(&self, jobs: &[Job]) -> Outcome<()> {
        let inputs = jobs.iter().map(|job| job.input.as_path());
        let results = jobs.iter().filter_map(Job::file);
        self.ci.check(inputs.chain(results).chain(self.depfile.as_deref()))?;
        Ok(batch::check_standard_streams(jobs, self.reports(), self.depfile.as_deref())?)
    }

    /// Does the work on one asset, and prints its failure, of which a panic is one, or its line of
    /// the report.
    ///
    /// # Errors
    /// If standard output cannot be written.
    pub(crate) fn one<R: Serialize>(
        &self,
        job: &Job,
        work: impl FnOnce() -> Outcome<JobResult<R>>,
    ) -> Outcome<Finished<R>> {
        let done = each::guarded(&job.input, work).inspect_err(each::print);
        let finished = match done {
            Ok(result) => Finished { status: Status::Done, result },
            Err(failure) => {
                let report = ResultReport::Failed(FailureReport::of(&job.input, &failure));
                let result = JobResult { report, rules: Vec::new() };
                Finished { status: failure.status, result }
            }
        };
        if self.format() == Some(ReportFormat::Jsonl) {
            console::json_line(&finished.result.report)?;
        }
        Ok(finished)
    }

    /// Finishes a run of a command: writes the dependency file, the JUnit file and the report, and
    /// says how many assets are done and have failed. `several` says whether the inputs stand for
    /// several assets. Returns the highest status.
    ///
    /// # Errors
    /// If one of them cannot be written.
    pub(crate) fn finish<R: Serialize>(
        &self,
        command: &str,
        several: bool,
        jobs: &[Job],
        done: Vec<Outcome<Finished<R>>>,
    ) -> Outcome<Status> {
        let done = done.into_iter().collect::<Outcome<Vec<_>>>()?;
        let worst = done.iter().map(|one| one.status).max().unwrap_or_default();
        let (mut summary, mut rules, mut suites) = (Summary::default(), Vec::new(), Vec::new());
        for (job, one) in jobs.iter().zip(&done) {
            match one.result.report {
                ResultReport::Done(_) => summary.built += 1,
                ResultReport::UpToDate(_) => summary.up_to_date += 1,
                ResultReport::Failed(_) => summary.failed += 1,
            }
            let own = one.result.rules.iter().cloned();
            rules.extend(own.map(|rule| rule.with_options_of(job)));
            suites.push(suite(command, &job.input, &one.result.report));
        }
        if let Some(depfile) = &self.depfile {
            output::write_depfile(depfile, &rules)?;
        }
        if jobs.iter().any(Job::is_listed) {
            let Summary { built, up_to_date, failed } = summary;
            let left =
                if self.if_changed { format!("{up_to_date} up to date, ") } else { String::new() };
            console::note(&format!("{built} done, {left}{failed} failed"));
        }
        self.ci.publish(&format!("lodc {command}"), &suites)?;
        match self.format() {
            Some(ReportFormat::Json) => {
                let results = done.into_iter().map(|one| one.result.report).collect();
                results::print(several, worst, results)?;
            }
            Some(ReportFormat::Jsonl) => console::json_line(&SummaryReport { summary })?,
            None => {}
        }
        Ok(worst)
    }
}

/// The work on one asset as CI systems show it.
fn suite<R>(command: &str, input: &Path, report: &ResultReport<R>) -> Suite {
    let verdict = match report {
        ResultReport::Failed(failure) => Verdict::Error(failure.error.clone()),
        ResultReport::Done(_) | ResultReport::UpToDate(_) => Verdict::Passed,
    };
    let cases = vec![Case { name: command.to_owned(), verdict }];
    Suite { name: input.display().to_string(), cases }
}
