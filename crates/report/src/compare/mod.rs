//! Comparisons of two meshes, or of levels of one: what they differ by, and which limits that
//! exceeds.

mod report;
mod suites;

pub use report::{
    BothWays, Comparison, ComparisonLimits, Content, ImageReport, Length, LevelComparison,
    PairReport, TriangleCounts,
};
