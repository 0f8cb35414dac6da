//! The checks of a report as CI systems show them.

use super::report::{CheckReport, FileReport, VerifyReport};
use crate::{Case, Suite, Verdict};

impl VerifyReport {
    /// A suite for each file.
    #[must_use]
    pub fn suites(&self) -> Vec<Suite> {
        self.files.iter().map(suite).collect()
    }
}

fn suite(file: &FileReport) -> Suite {
    let unread = file
        .error
        .as_ref()
        .map(|what| Case { name: "read".to_owned(), verdict: Verdict::Error(what.clone()) });
    let before = file
        .up_to_date
        .then(|| Case { name: "verified before, unchanged".to_owned(), verdict: Verdict::Passed });
    let cases = unread.into_iter().chain(before).chain(file.checks.iter().map(case)).collect();
    Suite { name: file.file.clone(), cases }
}

fn case(check: &CheckReport) -> Case {
    let object = check.object.as_deref().unwrap_or("file");
    let verdict = match (&check.first_difference, &check.skipped) {
        (Some(what), _) => Verdict::Failed(what.clone()),
        (None, Some(why)) => Verdict::Skipped(why.clone()),
        (None, None) => Verdict::Passed,
    };
    Case { name: format!("{object}: {}, {}, {}", check.model, check.check, check.device), verdict }
}
