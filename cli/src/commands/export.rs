//! Options, checks and final messages shared by the commands that write levels as mesh files
//! (extract, chain).

use super::asset::SimplifyArgs;
use super::estimate::{estimate, is_small};
use super::prune::{PruneArgs, Written};
use super::runs::{Finished, RunArgs};
use crate::batch::{self, BatchArgs, CommandPaths, Job, LEVEL_EXTENSIONS};
use crate::compression::CompressArgs;
use crate::config::ConfigArgs;
use crate::exit::{Outcome, Status};
use crate::jobs::{JobError, has_extension};
use crate::limits::ImportArgs;
use crate::mesh_output::FormatName;
use crate::output::Target;
use crate::program::Program;
use crate::textures::TextureArgs;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Options of commands that write levels of assets as mesh files.
#[derive(Args, Clone, Debug)]
pub(crate) struct ExportArgs {
    #[command(flatten)]
    pub(crate) simplify: SimplifyArgs,
    #[command(flatten)]
    pub(crate) textures: TextureArgs,
    #[command(flatten)]
    pub(crate) compress: CompressArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
    #[command(flatten)]
    pub(crate) prune: PruneArgs,
    #[command(flatten)]
    pub(crate) batch: BatchArgs,
    #[command(flatten)]
    configuration: ConfigArgs,
    #[command(flatten)]
    pub(crate) import: ImportArgs,
}

impl ExportArgs {
    /// Returns whether there is one input, in a small file.
    pub(crate) fn is_small(&self, inputs: &[PathBuf]) -> bool {
        !self.batch.takes_many(inputs) && inputs.iter().all(|input| is_small(input))
    }

    /// Checks that the options fit together. Returns the assets of a run, with their targets at
    /// `output` and their own options.
    ///
    /// # Errors
    /// If options do not fit together, or as [`batch::jobs`] and [`ConfigArgs::apply`].
    pub(crate) fn jobs(
        &self,
        (program, command): (&Program, &str),
        inputs: &[PathBuf],
        output: &Path,
        format: FormatName,
    ) -> Outcome<Vec<Job>> {
        let mut jobs = batch::jobs(self.paths(inputs, output, format), &self.batch)?;
        self.configuration.apply(program, command, &mut jobs)?;
        refuse_for_sequences(&program.given(command), &mut jobs);
        self.run.check(&jobs)?;
        let mut targets = jobs.iter().filter_map(|job| job.target.as_ref().ok());
        targets.try_for_each(|target| self.check(format, target))?;
        Ok(jobs)
    }

    fn paths<'a>(
        &'a self,
        inputs: &'a [PathBuf],
        output: &'a Path,
        format: FormatName,
    ) -> CommandPaths<'a> {
        CommandPaths {
            inputs,
            output: Some(output),
            input_extensions: &LEVEL_EXTENSIONS,
            output_extension: format.extension(),
            allowed_folders: self.import.allowed(),
        }
    }

    /// Finishes a run of a command: as [`RunArgs::finish`], then as [`PruneArgs::sweep`].
    ///
    /// # Errors
    /// As those.
    pub(crate) fn finish<R: Serialize>(
        &self,
        command: &str,
        (inputs, output, format): (&[PathBuf], &Path, FormatName),
        jobs: &[Job],
        done: Vec<Outcome<Finished<R>>>,
    ) -> Outcome<Status> {
        let several = self.batch.takes_many(inputs);
        let status = self.run.finish(command, several, jobs, done)?;
        let paths = self.paths(inputs, output, format);
        self.prune.sweep(paths, (&self.batch, jobs), Written::Recorded)?;
        Ok(status)
    }

    /// Checks that a format supports compression and textures as asked for.
    ///
    /// # Errors
    /// If it cannot.
    pub(crate) fn check(&self, format: FormatName, target: &Target) -> Outcome<()> {
        let input_is_compressed = false; // no matter for the check
        self.compress.wanted(format, input_is_compressed)?;
        self.textures.check(format, *target == Target::Stdout)
    }

    /// Bytes of memory that an asset may need, if it is a mesh.
    pub(crate) fn need(&self, input: &Path) -> Option<u64> {
        let needs = |size| self.simplify.needs(size);
        estimate(input, &self.import, needs).ok().map(|(_, bytes)| bytes)
    }
}

/// Options that decide a sequence, or how errors are measured with it, beside those of
/// [`ImportanceArgs`](crate::importance::ImportanceArgs).
const OF_SEQUENCES: [&str; 3] = ["metric", "weld", "poses"];

/// Refuses options of a sequence, if they are on the command line, for files that have one.
fn refuse_for_sequences(given: &[String], jobs: &mut [Job]) {
    let Some(option) = OF_SEQUENCES.iter().find(|option| given.iter().any(|g| g == *option)) else {
        return;
    };
    for job in jobs.iter_mut().filter(|job| has_extension(&job.input, &["lodc"])) {
        let input = job.input.display();
        let what = format!("{input}: its levels are stored: --{option} belongs to `lodc build`");
        job.target = Err(JobError::Usage(what));
    }
}
