//! Comparisons of two meshes, or of levels of one: their differences, and the limits that these
//! exceed.

mod report;
mod suites;

pub use report::{
    BothWays, Comparison, ComparisonLimits, Content, ImageReport, Length, LevelComparison,
    PairReport, TriangleCounts,
};
