//! Configuration files, `lodc.toml`: options for the assets in the same folder and below. A file
//! has layers: its options for all commands, for one command, of a profile, and overrides for the
//! inputs that a glob matches. A layer may have *parts*: options for objects or materials of an
//! asset, as `--part` has them. Those of all layers add up; where several match, the last one wins.

mod file;
mod find;

pub(crate) use file::ConfigLayer;

use crate::jobs::error::JobError;
use crate::jobs::options::{OptionValues, Vocabulary};
use crate::jobs::parts::IF_THERE;
use crate::jobs::run::Job;
use file::{ConfigFile, OptionTable};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The name of the files that are read without being named on the command line.
const FILE_NAME: &str = "lodc.toml";

/// Options that decide the collapse sequence: they cannot apply to a `.lodc` file, which has one.
const SEQUENCE_OPTIONS: [&str; 6] =
    ["lock", "lock-border", "metric", "no-attributes", "preserve-topology", "weight"];

/// The options of a part, as `--part` takes them.
fn json(part: &OptionTable) -> String {
    serde_json::to_string(part).expect("options are values of JSON")
}

/// The configurations of a run, each read once.
#[derive(Debug)]
pub(crate) struct Configs<'a> {
    /// The file that the command line names.
    path: Option<&'a Path>,
    profile: Option<&'a str>,
    vocabulary: &'a Vocabulary,
    command: &'a str,
    files: BTreeMap<PathBuf, Rc<ConfigFile>>,
}

impl<'a> Configs<'a> {
    /// The configurations for the assets of a command: the file at `path`, or else for each asset
    /// the nearest `lodc.toml` beside or above it; with the options of a profile, if one is named.
    #[must_use]
    pub(crate) fn new(
        path: Option<&'a Path>,
        profile: Option<&'a str>,
        vocabulary: &'a Vocabulary,
        command: &'a str,
    ) -> Self {
        Self { path, profile, vocabulary, command, files: BTreeMap::new() }
    }

    /// Returns the layers of options that an asset's configuration has for it, the strongest last.
    /// A `lodc.toml` is looked for up to `folder`; without one, up to the current folder.
    ///
    /// # Errors
    /// If the configuration cannot be read, has an unknown key, or lacks the profile.
    pub(crate) fn layers(
        &mut self,
        input: &Path,
        folder: Option<&Path>,
    ) -> Result<Vec<ConfigLayer>, JobError> {
        let Some(path) = self.file_of(input, folder) else { return self.layers_without_file() };
        if !self.files.contains_key(&path) {
            self.files.insert(path.clone(), Rc::new(ConfigFile::read(&path, self.vocabulary)?));
        }
        let file = Rc::clone(&self.files[&path]);
        file.layers(self.vocabulary, self.command, self.profile, input)
    }

    /// The configuration of an asset: the one that was named, or the nearest.
    fn file_of(&self, input: &Path, folder: Option<&Path>) -> Option<PathBuf> {
        match self.path {
            Some(path) => Some(path.to_owned()),
            None => find::nearest(FILE_NAME, input, folder),
        }
    }

    /// Adds the options of configurations to those that assets already have, which win. An asset
    /// that has a collapse sequence gets no options that decide one. `given` returns the long names
    /// of the options that the command line has, or that conflict with those; it is called only if
    /// there are parts.
    ///
    /// # Errors
    /// As for [`Self::layers`].
    pub(crate) fn apply(
        &mut self,
        jobs: &mut [Job],
        given: impl Fn() -> Vec<String>,
    ) -> Result<(), JobError> {
        let (command, mut given_options) = (self.vocabulary.command(self.command), None);
        for job in jobs {
            job.configuration = self.file_of(&job.input, job.folder.as_deref());
            let layers = self.layers(&job.input, job.folder.as_deref())?;
            let has_sequence =
                job.input.extension().is_some_and(|e| e.eq_ignore_ascii_case("lodc"));
            let applies = |option: &str| !has_sequence || !SEQUENCE_OPTIONS.contains(&option);
            let (mut configured, mut parts) = (OptionValues::default(), Vec::new());
            for layer in layers {
                configured = configured.overridden_by(layer.values, command);
                parts.extend(layer.part);
            }
            configured.0.retain(|option, _| applies(option));
            for part in &mut parts {
                let given = given_options.get_or_insert_with(&given);
                // The command line and the asset's line of a list win.
                part.retain(|option, _| {
                    let stronger = given.contains(option) || job.options.0.contains_key(option);
                    applies(option) && !stronger
                });
            }
            if !parts.is_empty() {
                // A configuration serves many assets: one that lacks a part is no error.
                let optional = |mut part: OptionTable| {
                    part.insert(IF_THERE.to_owned(), true.into());
                    json(&part)
                };
                let texts = parts.into_iter().map(optional);
                configured.0.insert("part".to_owned(), texts.collect());
            }
            let own = std::mem::take(&mut job.options);
            job.options = configured.overridden_by(own, command);
        }
        Ok(())
    }

    /// A message for each override of all configurations whose globs matched no input.
    #[must_use]
    pub(crate) fn unmatched(&self) -> Vec<String> {
        self.files.values().flat_map(|file| file.unmatched()).collect()
    }

    /// No layers, and an error if a profile is asked for: no file can have it.
    fn layers_without_file(&self) -> Result<Vec<ConfigLayer>, JobError> {
        match self.profile {
            Some(name) => Err(JobError::Usage(format!(
                "profile {name}: no {FILE_NAME} was found that could have it (--config names one)"
            ))),
            None => Ok(vec![]),
        }
    }
}
