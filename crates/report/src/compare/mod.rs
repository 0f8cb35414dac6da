//! What two meshes, or levels of one, differ by, and whether that is allowed.

mod report;
mod suites;

pub use report::{
    BothWays, Comparison, ComparisonLimits, Content, ImageReport, Length, LevelComparison,
    PairReport, TriangleCounts,
};
