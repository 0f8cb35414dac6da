//! Options, checks and final messages shared by the commands that write levels as mesh files
//! (extract, chain).

use super::asset::SimplifyArgs;
use super::each;
use crate::batch::{self, Asset, BatchArgs, Budget, CommandPaths, LEVEL_EXTENSIONS};
use crate::compression::CompressArgs;
use crate::config::ConfigArgs;
use crate::console;
use crate::exit::{Outcome, Status};
use crate::help::OUTPUT;
use crate::limits::ImportArgs;
use crate::mesh_output::FormatName;
use crate::output::{self, DependencyRule, Target};
use crate::program::Program;
use crate::results::{self, FailureReport, ResultReport};
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
    /// Print one JSON document on standard output
    #[arg(long, help_heading = OUTPUT)]
    pub(crate) json: bool,
    /// Write a Make/Ninja dependency file that names every file read
    #[arg(long, value_name = "FILE", help_heading = OUTPUT, hide_short_help = true)]
    pub(crate) depfile: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) batch: BatchArgs,
    #[command(flatten)]
    configuration: ConfigArgs,
    #[command(flatten)]
    pub(crate) import: ImportArgs,
}

/// The result of exporting one asset.
pub(crate) struct ExportResult<R> {
    /// Its part of the JSON document.
    pub(crate) report: R,
    /// Its rules for a dependency file: which files it read and wrote.
    pub(crate) rules: Vec<DependencyRule>,
}

impl ExportArgs {
    /// Returns whether there is one input, in a small file.
    pub(crate) fn is_small(&self, inputs: &[PathBuf]) -> bool {
        !self.batch.takes_many(inputs) && inputs.iter().all(|input| each::is_small(input))
    }

    /// Checks that the options fit together. Returns the assets of a run, with their targets at
    /// `output` and their own options.
    ///
    /// # Errors
    /// If options do not fit together, or as [`batch::assets`] and [`ConfigArgs::apply`].
    pub(crate) fn assets(
        &self,
        (program, command): (&Program, &str),
        inputs: &[PathBuf],
        output: &Path,
        format: FormatName,
    ) -> Outcome<Vec<Asset>> {
        let paths = CommandPaths {
            inputs,
            output: Some(output),
            input_extensions: &LEVEL_EXTENSIONS,
            output_extension: format.extension(),
            allowed_folders: self.import.allowed(),
        };
        let mut assets = batch::assets(paths, &self.batch)?;
        self.configuration.apply(program, command, &mut assets)?;
        batch::check_standard_streams(&assets, self.json, self.depfile.as_deref())?;
        let mut targets = assets.iter().filter_map(|asset| asset.target.as_ref().ok());
        targets.try_for_each(|target| self.check(format, target))?;
        Ok(assets)
    }

    /// Checks that a format supports compression and textures as asked for.
    ///
    /// # Errors
    /// If it cannot.
    pub(crate) fn check(&self, format: FormatName, target: &Target) -> Outcome<()> {
        self.compress.wanted(format, false)?;
        self.textures.check(format, *target == Target::Stdout)
    }

    /// Bytes of memory that an asset may need, if it is a mesh.
    pub(crate) fn need(&self, input: &Path) -> Option<u64> {
        let needs = |size| self.simplify.needs(size);
        each::estimate(input, &self.import, needs).ok().map(|(_, bytes)| bytes)
    }

    /// Workers and memory of a run; memory is unbounded where it is unknown.
    pub(crate) fn budget(&self) -> Budget {
        let bytes = self.import.limits().memory().unwrap_or(u64::MAX);
        Budget { workers: rayon::current_num_threads(), bytes }
    }

    /// Finishes a run: writes the dependency file and the JSON document, and prints how many assets
    /// are done and have failed. Returns the highest status.
    ///
    /// # Errors
    /// If the dependency file or standard output cannot be written.
    pub(crate) fn finish<R: Serialize>(
        &self,
        inputs: &[PathBuf],
        assets: &[Asset],
        done: Vec<Outcome<ExportResult<R>>>,
    ) -> Outcome<Status> {
        let (mut worst, mut results, mut rules) = (Status::Done, Vec::new(), Vec::new());
        for (asset, made) in assets.iter().zip(done) {
            results.push(match made {
                Ok(made) => {
                    rules.extend(made.rules);
                    ResultReport::Done(made.report)
                }
                Err(failure) => {
                    worst = worst.max(failure.status);
                    ResultReport::Failed(FailureReport::of(&asset.input, &failure))
                }
            });
        }
        if let Some(depfile) = &self.depfile {
            output::write_depfile(depfile, &rules)?;
        }
        if assets.iter().any(Asset::is_listed) {
            let failed = results.iter().filter(|r| matches!(r, ResultReport::Failed(_))).count();
            console::note(&format!("{} done, {failed} failed", results.len() - failed));
        }
        if self.json {
            results::print(self.batch.takes_many(inputs), worst, results)?;
        }
        Ok(worst)
    }
}

/// Does the work on one asset, and prints its failure; a panic is one, too.
///
/// # Errors
/// If the work fails.
pub(crate) fn one<R>(asset: &Asset, work: impl FnOnce() -> Outcome<R>) -> Outcome<R> {
    each::guarded(&asset.input, work).inspect_err(each::print)
}
