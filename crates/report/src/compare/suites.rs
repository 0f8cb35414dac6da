//! Comparisons as CI systems show them.

use super::PairReport;
use crate::{Case, Suite, Verdict};

impl PairReport {
    /// A suite under the name of the mesh that was compared with: that one is the author's.
    #[must_use]
    pub fn suite(&self) -> Suite {
        let cases = self.comparisons().into_iter().map(|(level, comparison)| Case {
            name: level.map_or_else(|| self.b.clone(), |level| format!("{} at {level}", self.b)),
            verdict: match comparison.exceeded.as_slice() {
                [] => Verdict::Passed,
                lines => Verdict::Failed(lines.join("; ")),
            },
        });
        Suite { name: self.a.clone(), cases: cases.collect() }
    }
}
