//! The optional section that records what a `.lodc` was built from: hashes of all source files and
//! the options. A later build compares it, never file times, to see whether the file is up to date.

use super::{VERSION, key};
use crate::fields::{decode, to_bytes};
use crate::{Assets, Fault, FormatError, GENERATOR, RequestedFiles};
use bincode::{Decode, Encode};
use std::path::Path;

/// Origin of a file's content: the optional section `MADE`.
#[derive(Clone, Debug, PartialEq, Eq, Encode, Decode)]
pub struct MadeFrom {
    /// A hash of everything that the content depends on: the input, the files that it names, the
    /// options, the versions of program and format.
    pub key: u128,
    /// The files that the input names, relative to its folder, in the order in which the key
    /// covers them: also those that were looked for and not there.
    pub files: Vec<String>,
    /// Warnings of the run that made the file.
    pub warnings: Vec<String>,
    /// The program and its version that made it.
    pub program: String,
}

impl MadeFrom {
    /// The origin of a result of `input`, for which `files` were looked for, with options as text
    /// and the warnings of the run. None if that is not certain: an input that came as a stream
    /// (`-`), a file that was read twice and had changed.
    #[must_use]
    pub fn of(
        input: &Path,
        files: &RequestedFiles,
        options: &str,
        warnings: &[String],
    ) -> Option<Self> {
        let mut hashed = Vec::new();
        let mut add = |bytes: &[u8]| {
            hashed.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
            hashed.extend_from_slice(bytes);
        };
        add(env!("CARGO_PKG_VERSION").as_bytes());
        add(&VERSION.to_le_bytes());
        add(options.as_bytes());
        let folder = input.parent().unwrap_or(Path::new(""));
        let mut names = Vec::new();
        let mut has_input = false;
        for (path, content) in files.contents()? {
            if path == input {
                has_input = content.is_some();
            } else {
                let name = path.strip_prefix(folder).unwrap_or(path).to_string_lossy();
                add(name.as_bytes());
                names.push(name.into_owned());
            }
            add(content.map(u128::to_le_bytes).as_ref().map_or(b"", |content| &content[..]));
        }
        let made = || Self {
            key: key(&hashed),
            files: names,
            warnings: warnings.to_vec(),
            program: GENERATOR.to_owned(),
        };
        has_input.then(made)
    }

    /// Returns every file that was looked for, if each of them is still what it was, or still not
    /// there. `assets` has the input as its main file and has read nothing.
    #[must_use]
    pub fn unchanged(
        &self,
        input: &Path,
        assets: &Assets,
        options: &str,
    ) -> Option<RequestedFiles> {
        if input.as_os_str() == "-" {
            return None;
        }
        let mut main = assets.clone();
        main.read_main().ok()?;
        let mut files = main.files().clone();
        for name in &self.files {
            // With a new count of bytes: the limit for all is on files that a build reads together.
            let mut assets = assets.clone();
            // A file that cannot be read is one of `files`, too: as absent.
            let _ = assets.read_reference(name);
            files.extend(assets.files());
        }
        let now = Self::of(input, &files, options, &self.warnings)?;
        (now == *self).then_some(files)
    }

    /// Returns whether this version made the file: then computing again gives the same numbers.
    #[must_use]
    pub fn is_of_this_version(&self) -> bool {
        self.program == GENERATOR
    }

    pub(super) fn bytes(&self) -> Vec<u8> {
        to_bytes(self)
    }

    /// Reads the section; what follows the known fields belongs to later versions.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, FormatError> {
        decode(bytes).ok_or_else(|| {
            FormatError::new(Fault::Malformed, "section MADE", "is truncated or not text")
        })
    }
}

#[cfg(test)]
#[path = "made_from_tests.rs"]
mod tests;
