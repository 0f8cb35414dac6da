//! The checks of `lodc verify`: of a file's models and errors, of its source, and of exported
//! levels; and their results.

mod facing;
mod geomorph;
mod levels;
mod models;
mod report;
mod suites;

pub use geomorph::check_geomorph;
pub use levels::check_levels;
pub use models::{check_errors_again, check_models, check_models_by_reference, check_source};
pub use report::{CheckReport, FileReport, VerifyReport, VerifySummary, VerifySummaryReport};
