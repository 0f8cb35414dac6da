//! `--baseline`: distances of the last time, in one file or in a file for each asset of a folder.

use super::CompareArgs;
use super::report::Numbers;
use crate::exit::{Failure, Outcome, Status};
use crate::output::{self, Target};
use crate::report::SCHEMA_VERSION;
use crate::text::distance;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Distances that are rounding, as shares of the diagonal, and grey levels that are.
const ROUNDING: [f64; 2] = [1e-6, 0.01];

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

/// An asset as it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Recorded {
    /// Options that the numbers depend on.
    options: String,
    /// By the name of the level.
    levels: BTreeMap<String, Numbers>,
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

impl Recorded {
    /// The asset as it is now.
    pub(super) fn now<'a>(
        args: &CompareArgs,
        levels: impl Iterator<Item = (&'a str, Numbers)>,
    ) -> Self {
        let levels = levels.map(|(name, now)| (name.to_owned(), now));
        Self { options: options(args), levels: levels.collect() }
    }

    /// Returns a level as it was.
    pub(super) fn level(&self, name: &str) -> Option<Numbers> {
        self.levels.get(name).copied()
    }
}

/// Returns a line for each number that is worse now by more than the share `tolerance`.
pub(super) fn worse(then: Numbers, now: Numbers, tolerance: f64, diagonal: f64) -> Vec<String> {
    let images = then.image_rmse.zip(now.image_rmse);
    let pairs = [
        Some(("rms distance", then.rms, now.rms, ROUNDING[0] * diagonal)),
        Some(("hausdorff distance", then.hausdorff, now.hausdorff, ROUNDING[0] * diagonal)),
        images.map(|(then, now)| ("image RMSE", then, now, ROUNDING[1])),
    ];
    let is_worse =
        |&(_, then, now, slack): &(_, f64, f64, f64)| now > then * (1.0 + tolerance) + slack;
    let line = |(name, then, now, _)| {
        format!("{name} {} is worse than {} of the baseline", distance(now), distance(then))
    };
    pairs.into_iter().flatten().filter(is_worse).map(line).collect()
}

/// Options that the numbers depend on, as text.
fn options(args: &CompareArgs) -> String {
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
