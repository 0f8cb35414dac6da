//! What is checked of a file, and what came of it.

mod facing;
mod levels;
mod models;
mod report;
mod suites;

pub use levels::check_levels;
pub use models::{check_errors_again, check_models, check_source};
pub use report::{CheckReport, FileReport, VerifyReport};
