//! Results of runs as CI systems read them: JUnit XML files, GitHub annotations.

use crate::console;
use crate::exit::{Failure, Outcome};
use crate::help::OUTPUT;
use crate::output::{self, Target, path_identity};
use clap::{Args, ValueEnum};
use lodc_report::{Suite, github, junit};
use std::path::{Path, PathBuf};

/// Options of commands that check many things.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = OUTPUT)]
pub(crate) struct CiArgs {
    /// Write the results as a JUnit file
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    junit: Option<PathBuf>,
    /// Print every failure as an annotation of this CI system, on standard error
    #[arg(long, value_enum, value_name = "SYSTEM", hide_short_help = true)]
    annotate: Option<Annotate>,
}

/// CI systems with annotations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Annotate {
    /// Workflow commands of GitHub Actions
    Github,
}

impl CiArgs {
    /// The JUnit file, if one is wanted.
    pub(crate) fn junit(&self) -> Option<&Path> {
        self.junit.as_deref()
    }

    /// Makes sure that the JUnit file can be written.
    ///
    /// # Errors
    /// If not, or if it is standard output or one of `others`, files that are read or written.
    pub(crate) fn check<'a>(&self, mut others: impl Iterator<Item = &'a Path>) -> Outcome<()> {
        let Some(junit) = &self.junit else { return Ok(()) };
        let identity = path_identity(junit);
        if output::is_standard_stream(junit) || others.any(|o| path_identity(o) == identity) {
            return Err(Failure::usage("--junit needs a file of its own"));
        }
        Ok(output::prepare_targets(&[Target::File(junit.clone())], false)?)
    }

    /// Writes the JUnit file and prints annotations, as far as they were asked for. `title` is the
    /// command.
    ///
    /// # Errors
    /// If the JUnit file cannot be written.
    pub(crate) fn publish(&self, title: &str, suites: &[Suite]) -> Outcome<()> {
        if let Some(Annotate::Github) = self.annotate {
            github(title, suites).for_each(|line| console::annotation(&line));
        }
        let Some(path) = &self.junit else { return Ok(()) };
        output::write(&Target::File(path.clone()), junit(title, suites).into_bytes())
    }
}
