//! What an earlier run recorded of its assets: one file for all, or a folder with a file for each.

use crate::jobs::error::JobError;
use crate::jobs::target::is_folder;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The records of an earlier run, a `T` for each asset.
#[derive(Debug)]
pub(crate) struct Baseline<T> {
    path: PathBuf,
    /// Whether `path` is a folder with a file for each asset; else it is one file.
    is_folder: bool,
    /// The records in the one file, by the assets' names; empty for a folder.
    assets: BTreeMap<String, T>,
}

/// The one file of a baseline, as JSON.
#[derive(Debug, Serialize, Deserialize)]
struct Document<T> {
    schema_version: u32,
    assets: BTreeMap<String, T>,
}

impl<T: Serialize + DeserializeOwned + Clone> Baseline<T> {
    /// Reads a baseline; a missing one is empty.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn open(path: &Path) -> Result<Self, JobError> {
        let is_folder = is_folder(path);
        let assets = match !is_folder && path.exists() {
            true => read::<Document<T>>(path)?.assets,
            false => BTreeMap::new(),
        };
        Ok(Self { path: path.to_owned(), is_folder, assets })
    }

    /// Its file or folder.
    #[must_use]
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the record of an asset; none if there is none.
    ///
    /// # Errors
    /// If its file cannot be read.
    pub(crate) fn record(&self, name: &str) -> Result<Option<T>, JobError> {
        let file = self.file(name);
        if !self.is_folder {
            return Ok(self.assets.get(name).cloned());
        }
        file.exists().then(|| read(&file)).transpose()
    }

    fn file(&self, name: &str) -> PathBuf {
        self.path.join(format!("{name}.json"))
    }

    /// Returns the files to write, as paths and texts, so that `new` is recorded; in the one file
    /// the records of other assets stay.
    #[must_use]
    pub(crate) fn files(
        mut self,
        schema_version: u32,
        new: Vec<(String, T)>,
    ) -> Vec<(PathBuf, String)> {
        if self.is_folder {
            return new
                .into_iter()
                .map(|(name, record)| (self.file(&name), text(&record)))
                .collect();
        }
        self.assets.extend(new);
        let document = Document { schema_version, assets: self.assets };
        vec![(self.path, text(&document))]
    }

    /// Returns whether it has a file for each asset, in folders that may have to be made.
    #[must_use]
    pub(crate) fn is_folder(&self) -> bool {
        self.is_folder
    }
}

fn read<T: DeserializeOwned>(path: &Path) -> Result<T, JobError> {
    let failure = |what: String| JobError::Input(format!("{}: {what}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| failure(e.to_string()))?;
    serde_json::from_str(&text).map_err(|e| failure(format!("not a baseline: {e}")))
}

fn text(document: &impl Serialize) -> String {
    let text = serde_json::to_string_pretty(document);
    text.expect("string keys and finite numbers") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_keeps_assets_that_are_not_new_and_a_folder_has_one_for_each() {
        let new = || vec![("a/x".to_owned(), 1), ("b".to_owned(), 2)];
        let assets = BTreeMap::from([("b".to_owned(), 7), ("c".to_owned(), 8)]);
        let file = Baseline { path: "f.json".into(), is_folder: false, assets };
        assert_eq!((file.record("b"), file.record("d")), (Ok(Some(7)), Ok(None)));
        let [(path, text)] = &file.files(1, new())[..] else { panic!("one file") };
        assert_eq!(path, Path::new("f.json"));
        let written: Document<u32> = serde_json::from_str(text).expect("a document");
        let all = [("a/x", 1), ("b", 2), ("c", 8)].map(|(name, n)| (name.to_owned(), n));
        assert_eq!(written.assets, BTreeMap::from(all));

        let folder = Baseline { path: "d".into(), is_folder: true, assets: BTreeMap::new() };
        let files = folder.files(1, new());
        assert_eq!(files[0], (Path::new("d").join("a/x.json"), "1\n".to_owned()));
        assert_eq!(files.len(), 2);
    }
}
