//! Options that choose the configuration file, `lodc.toml`.

use crate::console;
use crate::exit::Outcome;
use crate::help::CONFIGURATION;
use crate::jobs::{ConfigLayer, Configs, Job};
use crate::program::Program;
use clap::Args;
use std::path::{Path, PathBuf};

/// Options that choose a configuration.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = CONFIGURATION)]
pub(crate) struct ConfigArgs {
    /// Read options from FILE [default: the nearest lodc.toml above the input]
    ///
    /// The default is looked for up to the folder that was given or, for a named file, up to the
    /// current one. Options of the command line win.
    #[arg(long, value_name = "FILE", hide_short_help = true)]
    pub(crate) config: Option<PathBuf>,
    /// Also take the options of this profile of the configuration
    #[arg(long, value_name = "NAME", hide_short_help = true)]
    pub(crate) profile: Option<String>,
}

impl ConfigArgs {
    /// Adds the options of configurations to those of a command's assets, which win.
    ///
    /// # Errors
    /// As [`Configs::apply`].
    pub(crate) fn apply(&self, program: &Program, command: &str, jobs: &mut [Job]) -> Outcome<()> {
        let mut configs = self.configs(program, command);
        configs.apply(jobs, || program.given(command))?;
        // Of named files alone, an override for others is no mistake.
        if jobs.iter().any(|job| job.folder.is_some()) {
            configs.unmatched().iter().for_each(|what| console::note(&format!("lodc: {what}")));
        }
        Ok(())
    }

    /// Returns the layers of options that the configuration has for a named file.
    ///
    /// # Errors
    /// As [`Configs::layers`].
    pub(crate) fn layers(
        &self,
        program: &Program,
        command: &str,
        input: &Path,
    ) -> Outcome<Vec<ConfigLayer>> {
        Ok(self.configs(program, command).layers(input, None)?)
    }

    fn configs<'a>(&'a self, program: &'a Program, command: &'a str) -> Configs<'a> {
        let (path, profile) = (self.config.as_deref(), self.profile.as_deref());
        Configs::new(path, profile, program.vocabulary(), command)
    }
}
