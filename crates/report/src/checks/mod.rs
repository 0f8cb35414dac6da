//! What is checked of a file, and what came of it.

mod models;
mod report;
mod suites;

pub use models::{check_errors_again, check_models, check_source};
pub use report::{CheckReport, FileReport, VerifyReport};
