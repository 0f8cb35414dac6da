//! Records of what results were made from, for `--if-changed` and `--prune`: of `OUT/NAME` in
//! `OUT/.lodc/NAME.json`. A `.lodc` file says it itself.

use super::runs::{JobResult, RunArgs};
use crate::batch::{RECORDS, has_extension};
use crate::console;
use crate::exit::{Outcome, Status};
use crate::output::{self, DependencyRule, Target};
use crate::results::{ResultReport, UpToDateReport};
use lodc_formats::lodc::{MadeFrom, key};
use lodc_formats::{Assets, OutputFile, RequestedFiles};
use lodc_report::SCHEMA_VERSION;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What a result was made from, and its files. Paths are relative to the folder of the input or of
/// the result.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    key: String,
    files: Vec<String>,
    warnings: Vec<String>,
    program: String,
    /// The files of the result, each with a hash of its content.
    outputs: Vec<(String, String)>,
    /// Those of them that have a rule in a dependency file.
    ruled: Vec<String>,
}

/// The result that is to be made of an input.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    input: &'a Path,
    target: &'a Path,
    /// The files beside the input; nothing of them has been read.
    assets: &'a Assets,
    /// All options that can change the result.
    options: &'a str,
}

impl<'a> Wanted<'a> {
    /// What is wanted of an input, of which nothing has been read. None unless the run leaves
    /// results alone that are up to date, and the result is a file: only that can be.
    pub(crate) fn new(
        run: &RunArgs,
        input: &'a Path,
        target: &'a Target,
        assets: &'a Assets,
        options: &'a str,
    ) -> Option<Self> {
        let Target::File(target) = target else { return None };
        run.if_changed.then_some(Self { input, target, assets, options })
    }

    /// Returns the result if it is up to date; prints the warnings of the run that made it.
    pub(crate) fn if_up_to_date<R>(self) -> Option<JobResult<R>> {
        let record = Record::read(self.target)?;
        let made = record.made_from()?;
        let files = made.unchanged(self.input, self.assets, self.options)?;
        let folder = folder(self.target);
        let is_there = |(name, hash): &(String, String)| {
            fingerprint(&folder.join(name)).is_some_and(|now| now == *hash)
        };
        if !record.outputs.iter().all(is_there) {
            return None;
        }
        let input = self.input.display().to_string();
        console::warnings(&input, &record.warnings);
        let rule = |name: &String| DependencyRule::new(&folder.join(name), &files);
        let rules = record.ruled.iter().map(rule).collect();
        let output = self.target.display().to_string();
        let report = ResultReport::UpToDate(UpToDateReport {
            schema_version: SCHEMA_VERSION,
            input,
            status: Status::Done.code(),
            output,
            up_to_date: true,
            warnings: record.warnings,
        });
        Some(JobResult { report, rules })
    }

    /// Writes the record of a result that has been written: its `outputs`, the rules about them,
    /// the files that were read for it, and the warnings of the run. `images` are those among the
    /// files that were looked for last.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(crate) fn record(
        self,
        outputs: &[PathBuf],
        rules: &[DependencyRule],
        (read, images): (&RequestedFiles, &RequestedFiles),
        warnings: &[String],
    ) -> Outcome<()> {
        // A file with levels is listed as read, but without its hash: read it once more.
        let mut files = match has_extension(self.input, &["lodc"]) {
            true => {
                let mut assets = self.assets.clone();
                assets.read_main()?;
                assets.files().clone()
            }
            false => read.clone(),
        };
        files.extend(images);
        let folder = folder(self.target);
        let name =
            |path: &Path| path.strip_prefix(folder).unwrap_or(path).to_string_lossy().into_owned();
        let outputs = outputs.iter().map(|path| Some((name(path), fingerprint(path)?)));
        let (Some(made), Some(outputs)) =
            (MadeFrom::of(self.input, &files, self.options, warnings), outputs.collect())
        else {
            return Ok(());
        };
        let record = Record {
            key: format!("{:032x}", made.key),
            files: made.files,
            warnings: made.warnings,
            program: made.program,
            outputs,
            ruled: rules.iter().map(|rule| name(&rule.output)).collect(),
        };
        record.write(self.target)
    }
}

impl Record {
    /// The files of a result that has a record, with the record, without copies of images; none if
    /// it has none.
    pub(crate) fn files(target: &Path) -> Vec<PathBuf> {
        let Some(record) = Self::read(target) else { return Vec::new() };
        let own = target.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let outputs = record.outputs.into_iter().map(|(name, _)| name);
        // They stand beside the target, whatever a record says.
        let is_own = |name: &String| {
            name.starts_with(&own) && Path::new(name).file_name() == Some(name.as_ref())
        };
        let outputs = outputs.filter(is_own);
        outputs.map(|name| folder(target).join(name)).chain([path(target, ".json")]).collect()
    }

    fn read(target: &Path) -> Option<Self> {
        serde_json::from_slice(&std::fs::read(path(target, ".json")).ok()?).ok()
    }

    fn write(&self, target: &Path) -> Outcome<()> {
        let bytes = serde_json::to_vec_pretty(self).expect("strings are JSON");
        write(path(target, ".json"), bytes)
    }

    fn made_from(&self) -> Option<MadeFrom> {
        let key = u128::from_str_radix(&self.key, 16).ok()?;
        let (files, warnings) = (self.files.clone(), self.warnings.clone());
        Some(MadeFrom { key, files, warnings, program: self.program.clone() })
    }
}

/// The record of a file: `NAME` and an extension in the folder of records beside it.
pub(crate) fn path(of: &Path, extension: &str) -> PathBuf {
    let mut name = of.file_name().unwrap_or_default().to_owned();
    name.push(extension);
    folder(of).join(RECORDS).join(name)
}

/// Writes a record.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(path: PathBuf, bytes: Vec<u8>) -> Outcome<()> {
    output::prepare_targets([&Target::File(path.clone())], true)?;
    output::commit(&[OutputFile { path, bytes }])
}

fn folder(target: &Path) -> &Path {
    target.parent().unwrap_or(Path::new(""))
}

/// A hash of a file's content; none if it cannot be read.
fn fingerprint(path: &Path) -> Option<String> {
    let bytes = std::fs::read(path).ok()?;
    Some(format!("{:032x}", key(&bytes)))
}
