//! Results of checks as CI systems show them: JUnit files and annotations.

mod annotation;
mod junit;

pub use annotation::github;
pub use junit::junit;

/// The checks of one file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suite {
    /// The file.
    pub name: String,
    /// Its checks.
    pub cases: Vec<Case>,
}

/// One check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// What is checked.
    pub name: String,
    /// Its result.
    pub verdict: Verdict,
}

/// Result of a check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It holds.
    Passed,
    /// It was not made, and why.
    Skipped(String),
    /// It does not hold, and why.
    Failed(String),
    /// It could not be made, and why.
    Error(String),
}
