//! The list of files that an import looked for, each with the hash of its content or as absent. A
//! later build compares it to see whether anything has changed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::xxh3_128;

/// Files that were looked for, each once, in the order of the first look.
#[derive(Clone, Debug, Default)]
pub struct RequestedFiles {
    files: Vec<File>,
    /// The number of each file: a document may name any number of files that are not there.
    numbers: BTreeMap<PathBuf, usize>,
    /// True if a file had another content when it was read again.
    has_changed: bool,
}

#[derive(Clone, Debug)]
struct File {
    path: PathBuf,
    /// XXH3-128 of the bytes that were read; none if there were none to read.
    content: Option<u128>,
    /// True if another file was read instead.
    is_replaced: bool,
}

impl RequestedFiles {
    /// A list of one file that was read, without its hash.
    #[must_use]
    pub fn from_path(path: &Path) -> Self {
        let mut files = Self::default();
        // Any number: whoever records a hash reads the file once more.
        files.add(path, Some(0));
        files
    }

    /// Every file that was read.
    #[must_use]
    pub fn read_files(&self) -> Vec<PathBuf> {
        let read = self.files.iter().filter(|f| f.content.is_some());
        read.map(|f| f.path.clone()).collect()
    }

    /// Every file that was not there or could not be read, unless another was read instead.
    #[must_use]
    pub fn absent(&self) -> Vec<PathBuf> {
        let absent = self.files.iter().filter(|f| f.content.is_none() && !f.is_replaced);
        absent.map(|f| f.path.clone()).collect()
    }

    /// Every file with a hash of its content; none if one of them changed between two reads.
    pub(crate) fn contents(&self) -> Option<impl Iterator<Item = (&Path, Option<u128>)>> {
        (!self.has_changed).then(|| self.files.iter().map(|f| (f.path.as_path(), f.content)))
    }

    /// Adds the files of another list.
    pub fn extend(&mut self, others: &Self) {
        self.has_changed |= others.has_changed;
        for file in &others.files {
            self.add(&file.path, file.content);
            if file.is_replaced {
                self.set_replaced(&file.path);
            }
        }
    }

    pub(crate) fn add_read(&mut self, path: &Path, bytes: &[u8]) {
        self.add(path, Some(xxh3_128(bytes)));
    }

    pub(crate) fn add_absent(&mut self, path: &Path) {
        self.add(path, None);
    }

    /// Notes that another file was read instead of one that is not there.
    pub(crate) fn set_replaced(&mut self, path: &Path) {
        if let Some(&number) = self.numbers.get(path) {
            self.files[number].is_replaced = true;
        }
    }

    fn add(&mut self, path: &Path, content: Option<u128>) {
        if let Some(&number) = self.numbers.get(path) {
            self.has_changed |= self.files[number].content != content;
            return;
        }
        let path = path.to_owned();
        self.numbers.insert(path.clone(), self.files.len());
        self.files.push(File { path, content, is_replaced: false });
    }
}
