//! Results of `verify`. Their keys are a contract as those in `crate::report` are.

use serde::Serialize;

/// `verify --json`.
#[derive(Debug, Serialize)]
pub(crate) struct VerifyReport {
    pub(crate) schema_version: u32,
    pub(crate) ok: bool,
    pub(crate) files: Vec<FileReport>,
}

/// One file of a verification.
#[derive(Debug, Serialize)]
pub(crate) struct FileReport {
    pub(crate) file: String,
    pub(crate) ok: bool,
    pub(crate) checks: Vec<CheckReport>,
    /// Why there are no checks, if the file could not be read.
    pub(crate) error: Option<String>,
}

/// One check.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CheckReport {
    pub(crate) object: Option<String>,
    /// The model; `sequence` for facts stored with the collapse sequence, `source` for `--source`.
    pub(crate) model: &'static str,
    /// Name of the check.
    pub(crate) check: &'static str,
    pub(crate) device: &'static str,
    pub(crate) adapter: Option<String>,
    /// LODs compared.
    pub(crate) lods: u64,
    /// LODs of these at which whole meshes were compared triangle by triangle, not only their
    /// hashes.
    pub(crate) full: u64,
    /// Null if the check was skipped.
    pub(crate) ok: Option<bool>,
    pub(crate) skipped: Option<String>,
    pub(crate) first_difference: Option<String>,
}

impl CheckReport {
    /// A check about which nothing is known yet.
    pub(crate) fn new(object: Option<&str>, model: &'static str, check: &'static str) -> Self {
        Self {
            object: object.map(str::to_owned),
            model,
            check,
            device: "cpu",
            adapter: None,
            lods: 0,
            full: 0,
            ok: None,
            skipped: None,
            first_difference: None,
        }
    }

    /// The same of some LODs, all compared in full, with what differs first.
    pub(crate) fn of(self, lods: u64, first_difference: Option<String>) -> Self {
        Self { lods, full: lods, ok: Some(first_difference.is_none()), first_difference, ..self }
    }
}
