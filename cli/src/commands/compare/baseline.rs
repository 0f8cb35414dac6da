//! `--baseline`: distances of the last time, in one file or in a file for each asset of a folder.

use super::CompareArgs;
use crate::exit::{Failure, Outcome, Status};
use crate::output::{self, Target};
use crate::report::SCHEMA_VERSION;
use crate::text::distance;
use lodc_measure::{Numbers, Recorded, Worse};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The numbers of the last time.
#[derive(Debug)]
pub(super) struct Baseline {
    path: PathBuf,
    /// True: a folder with a file for each asset.
    is_folder: bool,
    record: bool,
    /// The assets of the only file.
    assets: BTreeMap<String, Recorded>,
}

/// The only file of a baseline.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Document {
    schema_version: u32,
    assets: BTreeMap<String, Recorded>,
}

impl Baseline {
    /// Reads the baseline, if one is wanted.
    ///
    /// # Errors
    /// If it cannot be read, or is not there and not to be recorded.
    pub(super) fn open(args: &CompareArgs) -> Outcome<Option<Self>> {
        let Some(path) = &args.baseline else { return Ok(None) };
        if output::is_stream(path) || args.named().is_some_and(|named| named.contains(&&**path)) {
            return Err(Failure::usage("--baseline needs a file or folder of its own"));
        }
        let is_folder = output::is_folder(path);
        if !args.record && !path.exists() {
            let what = "there is no baseline yet: record one with --record";
            return Err(Failure::new(Status::Input, format!("{}: {what}", path.display())));
        }
        let document: Document = match !is_folder && path.exists() {
            true => read(path)?,
            false => Document::default(),
        };
        let (path, record) = (path.clone(), args.record);
        Ok(Some(Self { path, is_folder, record, assets: document.assets }))
    }

    /// Returns an asset as it was; none if it was not recorded, or is to be recorded anew.
    ///
    /// # Errors
    /// If its file cannot be read, or it was recorded with other options.
    pub(super) fn of(&self, name: &str, args: &CompareArgs) -> Outcome<Option<Recorded>> {
        let file = self.file(name);
        let found = match (self.record, self.is_folder) {
            (true, _) => None,
            (false, true) if file.exists() => Some(read(&file)?),
            (false, true) => None,
            (false, false) => self.assets.get(name).cloned(),
        };
        match found {
            Some(recorded) if recorded.options != options(args) => {
                let what = format!("{name} was recorded with {}", recorded.options);
                let place = self.path.display();
                Err(Failure::usage(format!("{place}: {what}: record it again (--record)")))
            }
            found => Ok(found),
        }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.path.join(format!("{name}.json"))
    }

    /// Writes what was measured, if it is to be recorded; assets that were not measured stay.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn write(mut self, measured: Vec<(String, Recorded)>) -> Outcome<()> {
        if !self.record {
            return Ok(());
        }
        if self.is_folder {
            for (name, recorded) in measured {
                let target = Target::File(self.file(&name));
                output::prepare([&target], true)?;
                output::write(&target, bytes(&recorded))?;
            }
            return Ok(());
        }
        self.assets.extend(measured);
        let target = Target::File(self.path);
        output::prepare([&target], false)?;
        let document = Document { schema_version: SCHEMA_VERSION, assets: self.assets };
        output::write(&target, bytes(&document))
    }
}

/// Returns a line for each number that is worse now.
pub(super) fn worse(
    args: &CompareArgs,
    then: &Numbers,
    now: &Numbers,
    diagonal: f64,
) -> Vec<String> {
    let line = |Worse { name, now, then }| {
        format!("{name} {} is worse than {} of the baseline", distance(now), distance(then))
    };
    now.worse_than(then, args.tolerance, diagonal).into_iter().map(line).collect()
}

/// Options that the numbers depend on, as text.
pub(super) fn options(args: &CompareArgs) -> String {
    let CompareArgs { samples, seed, views, size, .. } = args;
    let attributes = if args.no_attributes { " --no-attributes" } else { "" };
    format!("--samples {samples} --seed {seed} --views {views} --size {size}{attributes}")
}

fn read<T: DeserializeOwned>(path: &Path) -> Outcome<T> {
    let failure = |what: String| Failure::new(Status::Input, format!("{}: {what}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| failure(e.to_string()))?;
    serde_json::from_str(&text).map_err(|e| failure(format!("is no baseline: {e}")))
}

fn bytes(document: &impl Serialize) -> Vec<u8> {
    let text = serde_json::to_string_pretty(document);
    (text.expect("string keys and finite numbers") + "\n").into_bytes()
}
