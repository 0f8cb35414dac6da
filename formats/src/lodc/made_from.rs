//! Origin of a file's content, so that a later run can see whether the file is up to date: by the
//! content of everything that it was made from, never by times.

use super::record::LIMIT;
use super::{VERSION, key};
use crate::{Fault, FormatError};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Origin of a file's content: the optional section `MADE`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MadeFrom {
    /// A hash of everything that the content depends on: the input, the files that it names, the
    /// options, the versions of program and format.
    pub key: u128,
    /// The files that the input names, relative to its folder, in the order in which the key
    /// covers them.
    pub files: Vec<String>,
}

impl MadeFrom {
    /// The origin of a result of `input` and the other files that were read for it, with options
    /// as text. None if that is not certain: an input that came as a stream (`-`), a file that has
    /// changed since `start`.
    #[must_use]
    pub fn of(input: &Path, files: &[PathBuf], options: &str, start: SystemTime) -> Option<Self> {
        let settled =
            |file: &Path| file.metadata().and_then(|m| m.modified()).is_ok_and(|t| t <= start);
        let known = input.as_os_str() != "-" && settled(input);
        if !known || !files.iter().all(|file| settled(file)) {
            return None;
        }
        let others = files.iter().filter(|file| *file != input);
        let named = |file: &PathBuf| {
            let name = file.strip_prefix(folder(input)).unwrap_or(file);
            name.to_string_lossy().into_owned()
        };
        let files: Vec<String> = others.map(named).collect();
        Some(Self { key: hash(input, &files, options)?, files })
    }

    /// Returns every file of a result that is up to date, the input first; none if something has
    /// changed or cannot be read.
    #[must_use]
    pub fn unchanged(&self, input: &Path, options: &str) -> Option<Vec<PathBuf>> {
        let same = hash(input, &self.files, options)? == self.key;
        let others = self.files.iter().map(|name| folder(input).join(name));
        same.then(|| std::iter::once(input.to_owned()).chain(others).collect())
    }

    pub(super) fn bytes(&self) -> Vec<u8> {
        bincode::serde::encode_to_vec(self, bincode::config::legacy())
            .expect("plain data can be written to memory")
    }

    /// Reads the section; what follows the known fields belongs to later versions.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, FormatError> {
        let config = bincode::config::legacy().with_limit::<LIMIT>();
        bincode::serde::decode_from_slice(bytes, config).map(|(made, _)| made).map_err(|e| {
            FormatError::new(Fault::Malformed, "section MADE", format!("cannot be decoded: {e}"))
        })
    }
}

/// A hash of program, format, options and the content of all files; none if one cannot be read.
fn hash(input: &Path, names: &[String], options: &str) -> Option<u128> {
    let mut all = Vec::new();
    let mut part = |bytes: &[u8]| {
        all.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
        all.extend_from_slice(bytes);
    };
    part(env!("CARGO_PKG_VERSION").as_bytes());
    part(&VERSION.to_le_bytes());
    part(options.as_bytes());
    part(&key(&fs::read(input).ok()?).to_le_bytes());
    for name in names {
        part(name.as_bytes());
        part(&key(&fs::read(folder(input).join(name)).ok()?).to_le_bytes());
    }
    Some(key(&all))
}

fn folder(input: &Path) -> &Path {
    input.parent().unwrap_or(Path::new(""))
}
