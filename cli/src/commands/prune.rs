//! Results in folders whose inputs are gone: named, or removed with `--prune`.

use super::records::Record;
use crate::batch::{self, BatchArgs, CommandPaths, Job};
use crate::console;
use crate::exit::Outcome;
use crate::help::OUTPUT;
use crate::jobs::{JobError, is_standard_stream};
use clap::Args;
use lodc_formats::lodc;
use lodc_report::text::count;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The option to remove such results.
#[derive(Args, Clone, Copy, Debug)]
#[command(next_help_heading = OUTPUT)]
pub(crate) struct PruneArgs {
    /// Of folders, remove results whose inputs are gone
    ///
    /// Those that lodc has written under the names that it gives them, and no copies of images.
    /// Without it a line names them.
    #[arg(long, hide_short_help = true)]
    prune: bool,
}

/// How it is known that lodc has written a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Written {
    /// The `.lodc` file says so.
    ByBuild,
    /// There is a record.
    Recorded,
}

impl Written {
    /// The files of a result that lodc has written; none if it has not.
    fn files(self, target: &Path) -> Vec<PathBuf> {
        match self {
            Self::ByBuild => {
                let made = std::fs::read(target).ok().and_then(|b| lodc::made_from(&b).ok());
                let verified = super::verify::record_path(target);
                made.flatten()
                    .map(|_| [target.to_owned(), verified])
                    .into_iter()
                    .flatten()
                    .collect()
            }
            Self::Recorded => Record::files(target),
        }
    }
}

impl PruneArgs {
    /// Names the results whose inputs are gone, or removes them, but none of a run's own `jobs`.
    /// A shard of a list that can be read once does not know the others', and leaves all alone.
    ///
    /// # Errors
    /// If one cannot be removed, or the list of jobs cannot be read again.
    pub(crate) fn sweep(
        self,
        paths: CommandPaths<'_>,
        (batch, jobs): (&BatchArgs, &[Job]),
        written: Written,
    ) -> Outcome<()> {
        let of_all_shards = match (batch.shard, &batch.manifest) {
            (None, _) => None,
            (Some(_), Some(list)) if is_standard_stream(list) => return Ok(()),
            (Some(_), _) => Some(batch::jobs(paths, &BatchArgs { shard: None, ..batch.clone() })?),
        };
        let jobs = of_all_shards.as_deref().unwrap_or(jobs);
        let orphans = batch::orphans(paths, jobs, written == Written::Recorded).into_iter();
        let gone = orphans.map(|target| (written.files(&target), target));
        let gone: Vec<(Vec<PathBuf>, PathBuf)> = gone.filter(|(f, _)| !f.is_empty()).collect();
        if self.prune {
            for (files, target) in &gone {
                files.iter().try_for_each(|file| remove(file))?;
                console::note(&format!("{}: removed, its input is gone", target.display()));
            }
            return Ok(());
        }
        match gone.as_slice() {
            [] => {}
            [(_, only)] => {
                let only = only.display();
                console::note(&format!("{only}: has no input any more: --prune removes it"));
            }
            [(_, first), ..] => {
                for (_, target) in &gone {
                    console::detail(&format!("{}: has no input any more", target.display()));
                }
                let (results, first) = (count(gone.len() as u64, "result"), first.display());
                let what = format!("{results} have no input any more, such as {first}");
                console::note(&format!("{what}: --prune removes them, --verbose names them"));
            }
        }
        Ok(())
    }
}

fn remove(file: &Path) -> Outcome<()> {
    match std::fs::remove_file(file) {
        Err(e) if e.kind() != ErrorKind::NotFound => {
            let what = format!("{}: not removed: {e}", file.display());
            Err(JobError::Output(what).into())
        }
        _ => Ok(()),
    }
}
