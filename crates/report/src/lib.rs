//! Results as people, browsers and CI systems read them: numbers in text, charts, the page that a
//! reviewer opens, the JSON documents of commands, checks with JUnit files, comparisons with the
//! limits that they exceed. It writes no file: results are structs to be serialised, text, XML and
//! HTML.
//!
//! ```
//! use lodc_report::{Case, CheckReport, Suite, Verdict, junit, text};
//!
//! let check = CheckReport::new(Some("chair"), "speed", "replay").of(1200, None);
//! assert_eq!((check.ok, text::count(check.lods, "LOD").as_str()), (Some(true), "1,200 LODs"));
//!
//! let case = Case { name: "chair: speed, replay".to_owned(), verdict: Verdict::Passed };
//! let suites = [Suite { name: "chair.lodc".to_owned(), cases: vec![case] }];
//! assert!(junit("lodc verify", &suites).contains("<testsuite name=\"chair.lodc\" tests=\"1\""));
//! ```

mod chart;
mod checks;
mod ci;
mod compare;
pub mod documents;
mod errors_over;
pub mod html;
mod missing_parts;
mod page;
mod sheet;
pub mod text;

pub use chart::{Chart, Curve, Scale, colour_of};
pub use checks::{
    CheckReport, FileReport, VerifyReport, VerifySummary, VerifySummaryReport, check_errors_again,
    check_geomorph, check_levels, check_models, check_models_by_reference, check_source,
};
pub use ci::{Case, Suite, Verdict, github, junit};
pub use compare::{
    BothWays, Comparison, ComparisonLimits, Content, ImageReport, Length, LevelComparison,
    PairReport, TriangleCounts,
};
pub use errors_over::ErrorsOver;
pub use missing_parts::{MissingPart, PartInventory};
pub use page::{PageContent, PageLevel, error_curve, page, page_levels};
pub use sheet::{Legend, Sheet};

/// Version of all documents; rises only if a key changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 1;
