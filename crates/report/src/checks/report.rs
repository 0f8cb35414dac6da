//! Results of checks. Their keys are a contract with scripts (docs/CLI.md): more may be added, none
//! may change.

use serde::Serialize;

/// `verify --json`.
#[derive(Debug, Serialize)]
pub struct VerifyReport {
    /// [`SCHEMA_VERSION`](crate::SCHEMA_VERSION).
    pub schema_version: u32,
    /// No check found a difference.
    pub ok: bool,
    /// Each file.
    pub files: Vec<FileReport>,
}

/// The last line of `verify --report jsonl`.
#[derive(Debug, Serialize)]
pub struct VerifySummaryReport {
    /// Numbers of files.
    pub summary: VerifySummary,
}

/// Numbers of files by their results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct VerifySummary {
    /// Verified now.
    pub verified: usize,
    /// Verified before.
    pub up_to_date: usize,
    /// With a difference, or not read.
    pub failed: usize,
}

impl VerifyReport {
    /// The numbers of files.
    #[must_use]
    pub fn summary(&self) -> VerifySummaryReport {
        let mut summary = VerifySummary::default();
        for file in &self.files {
            match (file.ok, file.up_to_date) {
                (false, _) => summary.failed += 1,
                (true, true) => summary.up_to_date += 1,
                (true, false) => summary.verified += 1,
            }
        }
        VerifySummaryReport { summary }
    }
}

/// One file of a verification.
#[derive(Debug, Serialize)]
pub struct FileReport {
    /// As it was named.
    pub file: String,
    /// No check found a difference, and it could be read.
    pub ok: bool,
    /// It was verified before, and nothing has changed since: there are no checks.
    pub up_to_date: bool,
    /// Each check.
    pub checks: Vec<CheckReport>,
    /// Why there are no checks, if the file could not be read.
    pub error: Option<String>,
}

/// One check.
#[derive(Clone, Debug, Serialize)]
pub struct CheckReport {
    /// The object; none for the whole file.
    pub object: Option<String>,
    /// What was checked: a structure (`speed`, `masking`, `interactive`), `sequence` for facts
    /// stored with the collapse sequence, `source` for `--source`, `levels` for exported levels.
    pub model: &'static str,
    /// Name of the check.
    pub check: &'static str,
    /// `cpu` or `gpu`.
    pub device: &'static str,
    /// The name of the graphics device.
    pub adapter: Option<String>,
    /// LODs compared.
    pub lods: u64,
    /// LODs of these at which whole meshes were compared triangle by triangle, not only their
    /// hashes.
    pub full: u64,
    /// Null if the check was skipped.
    pub ok: Option<bool>,
    /// Why it was skipped.
    pub skipped: Option<String>,
    /// What differs first.
    pub first_difference: Option<String>,
}

impl CheckReport {
    /// A check without a result yet.
    #[must_use]
    pub fn new(object: Option<&str>, model: &'static str, check: &'static str) -> Self {
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

    /// The check with its result: over this number of LODs, all compared in full, and the first
    /// difference.
    #[must_use]
    pub fn of(self, lods: u64, first_difference: Option<String>) -> Self {
        Self { lods, full: lods, ok: Some(first_difference.is_none()), first_difference, ..self }
    }
}
